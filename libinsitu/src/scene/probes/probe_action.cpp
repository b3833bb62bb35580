#include "scene/probes/probe_action.h"

#include <algorithm>
#include <limits>

#include "core/timer.h"
#include "core/unsigned_zero.h"
#include "output/files/atomic_file.h"
#include "output/files/json_text.h"
#include "query/walk/attached.h"
#include "scene/probes/curtain.h"
#include "scene/run/failures.h"
#include "scene/run/lookup.h"
#include "scene/run/own_cell.h"

namespace insitu::scene {

ProbeAction::ProbeAction(const Probe& probe, const Environment& environment)
    : probe_(probe), environment_(environment), netcdf_(probe.name, environment, moves()) {}

ProbeAnswers ProbeAction::sample(const commit::CommittedMesh& mesh,
                                 std::span<const mesh::FieldView> fields) {
  const core::Timer timer;
  ProbeAnswers a;
  a.fields.assign(fields.begin(), fields.end());
  for (const mesh::FieldView& f : fields)
    for (std::string& column : component_names(f))
      a.columns.push_back(std::move(column));
  const std::vector<math::Vec3d>& points = points_->mesh_points;
  const std::size_t n = points.size(), width = a.columns.size();
  a.locations.resize(n);
  a.values.assign(n * width, std::numeric_limits<double>::quiet_NaN());
  const query::Sampler sampler = mesh.sampler();
  query::LocateOptions options;
  options.accuracy = probe_.accuracy;
  if (moves()) { // their places are known, to the bit
    for (std::size_t i = 0; i < n; ++i) {
      if (places_[i])
        sampler.interpolate(a.fields, places_[i], a.values.data() + i * width);
      a.locations[i] = mesh.own(places_[i], points[i]);
    }
  } else {
    sampler.visit(environment_.context.threads, points, options,
                  [&](const query::Answered& answered) {
                    for (std::size_t k = 0; k < answered.locations.size(); ++k) {
                      const std::size_t i = answered.item(k);
                      a.locations[i] = answered.locations[k];
                      if (a.locations[i])
                        sampler.interpolate(a.fields, a.locations[i], a.values.data() + i * width);
                      a.locations[i] = mesh.own(a.locations[i], points[i]);
                    }
                  });
  }
  Statistics& s = environment_.statistics;
  s.points_located += std::int64_t(n);
  s.points_outside += std::count_if(a.locations.begin(), a.locations.end(),
                                    [](const query::Location& l) { return !l; });
  s.query_s += timer.seconds();
  return a;
}

void ProbeAction::plan(const commit::CommittedMesh& mesh, Plan& plan) const {
  std::string fields;
  for (const Name& name : probe_.fields)
    fields += (fields.empty() ? "'" : ", '") + name.text + "'";
  for (const Name& name : probe_.fields)
    find_field(mesh, name, environment_.scene_file);
  plan.need("point queries", -1, fields.empty() ? "of all fields" : "of " + fields);
}

/// Takes attached points to where the material has carried them; at every cycle, so that they are
/// known when the cells change. Points that are outside stay where they are.
void ProbeAction::follow(commit::CommittedMesh& mesh) {
  std::vector<math::Vec3d>& points = points_->mesh_points;
  const bool same_cells = !places_.empty() && (topology_ == mesh.topology_version() || same_cells_);
  same_cells_ = false;
  places_.resize(points.size());
  const query::Sampler sampler = mesh.sampler();
  query::LocateOptions options;
  options.accuracy = probe_.accuracy;
  environment_.context.threads.parallel_for(
      std::int64_t(points.size()), 512, [&](std::int64_t begin, std::int64_t end) {
        for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
          query::follow(sampler, same_cells, options, places_[i], points[i]);
      });
  topology_ = mesh.topology_version();
}

std::string ProbeAction::state_name() const {
  return moves() ? "probe '" + probe_.name + "' (attached: body)" : "";
}

/// Names with the points: those of a file are not read again after a restart.
void ProbeAction::keep(core::Archive& archive) {
  if (!moves())
    return;
  bool placed = points_.has_value();
  archive.value("placed", placed);
  if (!placed)
    return;
  if (!points_)
    points_.emplace();
  std::vector<std::int64_t> cells;
  std::vector<math::Vec3d> parametric;
  for (const query::Location& at : places_) {
    cells.push_back(at.cell);
    parametric.push_back(at.parametric);
  }
  archive.array("points", points_->mesh_points);
  archive.array("names", points_->names);
  archive.array("cells", cells);
  archive.array("parametric coordinates", parametric);
  if (!archive.restores())
    return;
  places_.clear();
  for (std::size_t i = 0; i < cells.size(); ++i)
    places_.push_back({cells[i], parametric[i]});
}

void ProbeAction::execute(commit::CommittedMesh& mesh, const Step& step, bool due) {
  if (!due && !moves())
    return;
  const core::Timer preparing;
  if (!points_)
    points_ = resolve_points(probe_.points, probe_.frame, mesh, environment_.scene_file);
  if (moves())
    follow(mesh);
  if (!due) {
    environment_.statistics.query_s += preparing.seconds();
    return;
  }
  if (probe_.fields.empty() && mesh.mesh().field_names().empty() &&
      mesh.mesh().own_view().cell_count() == 0)
    return;                  // the fields that the mesh will have are not known yet
  if (probe_.fields.empty()) // all of the first time: a table keeps its columns
    for (const std::string& name : mesh.mesh().field_names())
      probe_.fields.push_back({name, probe_.line});
  environment_.statistics.query_s += preparing.seconds();
  std::vector<mesh::FieldView> fields;
  for (const Name& name : probe_.fields)
    fields.push_back(find_field(mesh, name, environment_.scene_file));
  const ProbeAnswers answers = sample(mesh, fields);
  const core::Timer timer;
  if (environment_.page)
    environment_.page->add_probe(probe_.name, answers.columns, points_->mesh_points, points_->names,
                                 answers.values);
  Failures failures;
  bool in_a_table = false;
  for (const TableFormat format : probe_.output)
    failures.catch_of([&] {
      write(format, mesh, step, answers);
      in_a_table |= format == TableFormat::csv || format == TableFormat::netcdf;
    });
  if (in_a_table)
    environment_.statistics.probe_rows += std::int64_t(answers.locations.size());
  environment_.statistics.output_s += timer.seconds();
  failures.throw_if_any();
}

void ProbeAction::write(TableFormat format, const commit::CommittedMesh& mesh, const Step& step,
                        const ProbeAnswers& answers) {
  switch (format) {
  case TableFormat::csv:
    write_table(mesh, step, answers);
    break;
  case TableFormat::vtp:
    write_vtp(mesh, step, answers);
    break;
  case TableFormat::json:
    write_json(mesh, step, answers);
    break;
  case TableFormat::netcdf:
    netcdf_.write(mesh, step, *points_, answers);
    break;
  }
}

void ProbeAction::write_table(const commit::CommittedMesh& mesh, const Step& step,
                              const ProbeAnswers& answers) {
  const mesh::MeshView& view = mesh.mesh().own_view();
  const bool names = !points_->names.empty();
  if (!table_)
    pieces_ = names_pieces(mesh.mesh());
  std::vector<std::string> columns{"cycle", "time", "point"};
  if (names)
    columns.push_back("name");
  if (moves())
    columns.insert(columns.end(), {"x", "y", "z"});
  const CurtainPlaces* curtain = points_->curtain ? &*points_->curtain : nullptr;
  if (curtain)
    columns.insert(columns.end(), {"distance", level_name(*curtain)});
  columns.push_back("cell");
  if (pieces_)
    columns.push_back("piece");
  columns.insert(columns.end(), {"r", "s", "t"});
  columns.insert(columns.end(), answers.columns.begin(), answers.columns.end());
  if (table_) {
    require_columns(*table_, columns_, columns);
    one_piece_.say(!pieces_ && names_pieces(mesh.mesh()), table_->path(), environment_.context.log);
  } else {
    columns_ = columns;
    table_ = std::make_unique<output::AppendTable>(environment_.output + "/" + probe_.name + ".csv",
                                                   std::move(columns), step.cycle);
    ++environment_.statistics.files;
  }
  output::CsvRows& rows = table_->rows();
  const std::size_t width = answers.columns.size();
  for (std::size_t i = 0; i < answers.locations.size(); ++i) {
    const query::Location& at = answers.locations[i];
    rows.cell(step.cycle).cell(step.time).cell(std::int64_t(i));
    if (names)
      rows.cell(points_->names[i]);
    for (int c = 0; moves() && c < 3; ++c)
      rows.cell(core::unsigned_zero(points_->mesh_points[i][c]));
    if (curtain)
      rows.cell(core::unsigned_zero(curtain->distances[i / curtain->levels.size()]))
          .cell(core::unsigned_zero(curtain->levels[i % curtain->levels.size()]));
    const OwnCell own = own_cell(view, at.cell);
    rows.cell(pieces_ ? own.cell : own.flat);
    if (pieces_)
      rows.cell(int(own.piece));
    for (int c = 0; c < 3; ++c)
      rows.cell(at ? core::unsigned_zero(at.parametric[c])
                   : std::numeric_limits<double>::quiet_NaN());
    for (std::size_t c = 0; c < width; ++c)
      rows.cell(answers.values[i * width + c]);
    rows.end_row();
  }
  flush_table(*table_);
}

void ProbeAction::write_vtp(const commit::CommittedMesh& mesh, const Step& step,
                            const ProbeAnswers& answers) {
  const mesh::MeshView& view = mesh.mesh().own_view();
  std::vector<std::int64_t> cells;
  std::vector<std::int32_t> pieces;
  for (const query::Location& at : answers.locations) {
    const OwnCell own = own_cell(view, at.cell);
    cells.push_back(own.cell);
    pieces.push_back(own.piece);
  }
  const VtkColumns columns(answers.columns, answers.values);
  const std::optional<CurtainSurface> surface =
      points_->curtain
          ? std::optional<CurtainSurface>(std::in_place, *points_, mesh.reference_frame)
          : std::nullopt;
  output::VtkPolyData data;
  data.points = vtk_points(surface ? surface->points : points_->mesh_points);
  if (surface)
    surface->add_to(data);
  data.point_data.push_back(output::vtk_array("cell", std::span<const std::int64_t>(cells)));
  if (names_pieces(mesh.mesh()))
    data.point_data.push_back(output::vtk_array("piece", std::span<const std::int32_t>(pieces)));
  columns.add_to(data.point_data);
  series_.write(environment_, probe_.name, step, data);
}

void ProbeAction::write_json(const commit::CommittedMesh& mesh, const Step& step,
                             const ProbeAnswers& answers) {
  const mesh::MeshView& view = mesh.mesh().own_view();
  const bool pieces = names_pieces(mesh.mesh());
  const CurtainPlaces* curtain = points_->curtain ? &*points_->curtain : nullptr;
  const std::size_t width = answers.columns.size();
  output::JsonText json = output::JsonText::spaced();
  json.open('{').key("cycle").value(step.cycle).key("time").value(step.time);
  json.key("columns").open('[');
  if (curtain)
    json.value("distance").value(level_name(*curtain));
  if (moves())
    json.value("x").value("y").value("z");
  json.value("cell");
  if (pieces)
    json.value("piece");
  for (const std::string& c : answers.columns)
    json.value(c);
  json.close().key("points").open('[');
  for (std::size_t i = 0; i < answers.locations.size(); ++i) {
    const OwnCell own = own_cell(view, answers.locations[i].cell);
    json.line().open('[');
    if (curtain)
      json.value(curtain->distances[i / curtain->levels.size()])
          .value(curtain->levels[i % curtain->levels.size()]);
    for (int c = 0; moves() && c < 3; ++c)
      json.value(points_->mesh_points[i][c]);
    json.value(own.cell);
    if (pieces)
      json.value(own.piece);
    for (std::size_t c = 0; c < width; ++c)
      json.value(answers.values[i * width + c]);
    json.close();
  }
  json.close().close();
  output::AtomicFile file(cycle_path(environment_, probe_.name, step.cycle, ".json"));
  file.write(json.text() + "\n");
  file.commit();
  ++environment_.statistics.files;
}

void ProbeAction::finish() {
  Failures failures;
  failures.catch_of([&] {
    if (table_)
      table_->flush();
  });
  failures.catch_of([&] { netcdf_.finish(); });
  table_.reset();
  failures.throw_if_any();
}

} // namespace insitu::scene

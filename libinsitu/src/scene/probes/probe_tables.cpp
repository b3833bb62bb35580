#include "scene/probes/probe_tables.h"

#include <limits>
#include <optional>

#include "core/unsigned_zero.h"
#include "output/files/atomic_file.h"
#include "output/files/json_text.h"
#include "scene/probes/curtain.h"
#include "scene/run/failures.h"

namespace insitu::scene {

/// What is written at a due cycle.
struct ProbeTables::Rows {
  const commit::CommittedMesh& mesh;
  const Step& step;
  const ScenePoints& points;
  const ProbeAnswers& answers;
  const CellNames& names;

  const CurtainPlaces* curtain() const { return points.curtain ? &*points.curtain : nullptr; }
};

ProbeTables::ProbeTables(const Probe& probe, const Environment& environment)
    : name_(probe.name), formats_(probe.output), moves_(probe.attached == Attached::body),
      environment_(environment), netcdf_(probe.name, environment, moves_) {}

void ProbeTables::write(const commit::CommittedMesh& mesh, const Step& step,
                        const ScenePoints& points, const ProbeAnswers& answers,
                        const CellNames& names) {
  const Rows rows{mesh, step, points, answers, names};
  counted_ = note_.again(step) && counted_;
  written_.write(step, formats_.size(), [&](std::size_t i) {
    switch (formats_[i]) {
    case TableFormat::csv:
      write_csv(rows);
      count(rows);
      break;
    case TableFormat::vtp:
      write_vtp(rows);
      break;
    case TableFormat::json:
      write_json(rows);
      break;
    case TableFormat::netcdf:
      netcdf_.write(mesh, step, points, answers, names);
      count(rows);
      break;
    }
  });
}

/// Rows that are in two tables count once.
void ProbeTables::count(const Rows& of) {
  if (!counted_)
    environment_.statistics.probe_rows += std::int64_t(of.answers.cells.size());
  counted_ = true;
}

void ProbeTables::write_csv(const Rows& of) {
  const auto& [mesh, step, points, answers, names_now] = of;
  const bool names = !points.names.empty();
  if (!table_)
    names_ = names_now;
  std::vector<std::string> columns{"cycle", "time", "point"};
  if (names)
    columns.push_back("name");
  if (moves_)
    columns.insert(columns.end(), {"x", "y", "z"});
  const CurtainPlaces* curtain = of.curtain();
  if (curtain)
    columns.insert(columns.end(), {"distance", level_name(*curtain)});
  columns.push_back("cell");
  if (names_.pieces)
    columns.push_back("piece");
  if (names_.processes)
    columns.push_back("process");
  columns.insert(columns.end(), {"r", "s", "t"});
  columns.insert(columns.end(), answers.columns.begin(), answers.columns.end());
  if (table_) {
    require_columns(*table_, columns_, columns);
    names_.require_for(table_->path(), names_now);
    one_piece_.say(!names_.pieces && !names_.global && names_now.pieces, table_->path(),
                   environment_.context.log);
  } else {
    columns_ = columns;
    table_ = std::make_unique<output::AppendTable>(environment_.output + "/" + name_ + ".csv",
                                                   std::move(columns), step.cycle);
    ++environment_.statistics.files;
  }
  rows_.write(*table_, step, [&] { add_rows(of); });
}

void ProbeTables::add_rows(const Rows& of) {
  const auto& [mesh, step, points, answers, names_now] = of;
  const CurtainPlaces* curtain = of.curtain();
  output::CsvRows& rows = table_->rows();
  const std::size_t width = answers.columns.size();
  for (std::size_t i = 0; i < answers.cells.size(); ++i) {
    rows.cell(step.cycle).cell(step.time).cell(std::int64_t(i));
    if (!points.names.empty())
      rows.cell(points.names[i]);
    for (int c = 0; moves_ && c < 3; ++c)
      rows.cell(core::unsigned_zero(points.mesh_points[i][c]));
    if (curtain)
      rows.cell(core::unsigned_zero(curtain->distances[i / curtain->levels.size()]))
          .cell(core::unsigned_zero(curtain->levels[i % curtain->levels.size()]));
    const OwnCell& own = answers.cells[i];
    rows.cell(names_.cell(own));
    if (names_.pieces)
      rows.cell(int(own.piece));
    if (names_.processes)
      rows.cell(int(own.process));
    for (int c = 0; c < 3; ++c)
      rows.cell(answers.found(i) ? core::unsigned_zero(answers.parametric[i][c])
                                 : std::numeric_limits<double>::quiet_NaN());
    for (std::size_t c = 0; c < width; ++c)
      rows.cell(answers.values[i * width + c]);
    rows.end_row();
  }
}

void ProbeTables::write_vtp(const Rows& of) {
  const auto& [mesh, step, points, answers, names] = of;
  std::vector<std::int64_t> cells;
  std::vector<std::int32_t> pieces, processes;
  for (const OwnCell& own : answers.cells) {
    cells.push_back(names.cell(own));
    pieces.push_back(own.piece);
    processes.push_back(own.process);
  }
  const VtkColumns columns(answers.columns, answers.values);
  const std::optional<CurtainSurface> surface =
      points.curtain ? std::optional<CurtainSurface>(std::in_place, points, mesh.reference_frame)
                     : std::nullopt;
  output::VtkPolyData data;
  data.points = vtk_points(surface ? surface->points : points.mesh_points);
  if (surface)
    surface->add_to(data);
  data.point_data.push_back(output::vtk_array("cell", std::span<const std::int64_t>(cells)));
  if (names.pieces)
    data.point_data.push_back(output::vtk_array("piece", std::span<const std::int32_t>(pieces)));
  if (names.processes)
    data.point_data.push_back(
        output::vtk_array("process", std::span<const std::int32_t>(processes)));
  columns.add_to(data.point_data);
  series_.write(environment_, name_, step, data);
}

void ProbeTables::write_json(const Rows& of) {
  const auto& [mesh, step, points, answers, names] = of;
  const CurtainPlaces* curtain = of.curtain();
  const std::size_t width = answers.columns.size();
  output::JsonText json = output::JsonText::spaced();
  json.open('{').key("cycle").value(step.cycle).key("time").value(step.time);
  json.key("columns").open('[');
  if (curtain)
    json.value("distance").value(level_name(*curtain));
  if (moves_)
    json.value("x").value("y").value("z");
  json.value("cell");
  if (names.pieces)
    json.value("piece");
  if (names.processes)
    json.value("process");
  for (const std::string& c : answers.columns)
    json.value(c);
  json.close().key("points").open('[');
  for (std::size_t i = 0; i < answers.cells.size(); ++i) {
    const OwnCell& own = answers.cells[i];
    json.line().open('[');
    if (curtain)
      json.value(curtain->distances[i / curtain->levels.size()])
          .value(curtain->levels[i % curtain->levels.size()]);
    for (int c = 0; moves_ && c < 3; ++c)
      json.value(points.mesh_points[i][c]);
    json.value(names.cell(own));
    if (names.pieces)
      json.value(own.piece);
    if (names.processes)
      json.value(own.process);
    for (std::size_t c = 0; c < width; ++c)
      json.value(answers.values[i * width + c]);
    json.close();
  }
  json.close().close();
  output::AtomicFile file(cycle_path(environment_, name_, step.cycle, ".json"));
  file.write(json.text() + "\n");
  file.commit();
  ++environment_.statistics.files;
}

void ProbeTables::finish() {
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

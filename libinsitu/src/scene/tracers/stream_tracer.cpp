#include <algorithm>

#include "core/status.h"
#include "core/timer.h"
#include "core/unsigned_zero.h"
#include "scene/run/environment.h"
#include "scene/run/failures.h"
#include "scene/run/lookup.h"
#include "scene/run/own_cell.h"
#include "scene/run/step.h"
#include "scene/tracers/drawn_lines.h"
#include "scene/tracers/gathered_lines.h"
#include "scene/tracers/mesh_homes.h"
#include "scene/tracers/tracer_action.h"
#include "scene/tracers/tracer_cells.h"
#include "scene/tracers/tracer_effects.h"
#include "scene/tracers/vtp_series.h"

namespace insitu::scene {

namespace {

/// Streamlines of the velocity as it is when due.
class StreamTracer final : public TracerAction {
public:
  using TracerAction::TracerAction;

  advect::Counts counts() const override { return counts_; }
  void keep(core::Archive& archive) override {
    archive.value("seeded", counts_.seeded);
    archive.value("endings", counts_.by_ending);
  }

  void execute(commit::CommittedMesh& mesh, const Step& step, bool due) override {
    if (!due)
      return;
    counts_before_ = note_.again(step) ? counts_before_ : counts_;
    counts_ = counts_before_; // lines of a step that comes again count once
    if (across())
      return execute_across(mesh, step);
    const core::Timer timer;
    advect::StreamlineSettings settings = line_settings();
    settings.effects = effects_at(tracer_, mesh, step, 0, environment_.scene_file);
    mesh.look_for_folds(environment_.context.threads); // particles ask with hints
    mesh.find_neighbours_if_due(environment_.context.threads);
    const mesh::FieldView velocity = find_field(mesh, tracer_.velocity, environment_.scene_file);
    const core::Threads& threads = environment_.context.threads;
    const auto left_out = [&] { return cells_.left_out(mesh, threads); };
    advect::Exits exits(mesh.sampler(), left_out, settings.accuracy);
    settings.exits = &exits;
    const advect::Streamlines streamlines =
        advect::trace_streamlines(cells_.sampler(mesh, {&velocity, 1}, threads), velocity,
                                  seeds(mesh), settings, threads, environment_.context.memory);
    counts_ += streamlines.counts;
    environment_.statistics.advect_s += timer.seconds();
    const core::Timer output_timer;
    const advect::Polylines& lines = streamlines.lines;
    const std::vector<mesh::FieldView> recorded = fields(mesh);
    const std::vector<std::string> columns = field_columns(recorded);
    const std::vector<double> values =
        sample(mesh, recorded, lines.points.span(), lines.cells.span());
    std::vector<OwnCell> cells;
    for (std::size_t v = 0; v < lines.points.size(); ++v)
      cells.push_back(own_cell(mesh, lines.cells[v], lines.points[v], environment_.world));
    const CellNames names = name_cells(mesh.mesh(), environment_.world);
    write(step, lines, {names, cells}, columns, values);
    environment_.statistics.output_s += output_timer.seconds();
  }

  std::optional<advect::Counts> particles_here() const override {
    // The root has those of all lines.
    return environment_.world.is_root() ? counts_ : advect::Counts();
  }

private:
  bool across() const { return environment_.world.size() > 1; }
  advect::StreamlineSettings line_settings() const {
    advect::StreamlineSettings settings;
    settings.integrator = integrator();
    settings.direction = tracer_.direction == TracerDirection::both ? advect::Direction::both
                         : tracer_.direction == TracerDirection::backward
                             ? advect::Direction::backward
                             : advect::Direction::forward;
    settings.even_length = tracer_.spacing.length.value_or(0.0);
    settings.even_time = tracer_.spacing.time.value_or(0.0);
    settings.accuracy = tracer_.accuracy;
    if (tracer_.until.duration)
      settings.duration = *tracer_.until.duration;
    if (tracer_.effects.age_limit)
      settings.duration = std::min(settings.duration, *tracer_.effects.age_limit);
    if (tracer_.until.length)
      settings.length = *tracer_.until.length;
    return settings;
  }
  void execute_across(commit::CommittedMesh& mesh, const Step& step);

  /// The cells of the lines' vertices, and how files name them.
  struct Cells {
    const CellNames& names;
    const std::vector<OwnCell>& of;
  };
  void write(const Step& step, const advect::Polylines& lines, const Cells& cells,
             const std::vector<std::string>& columns, const std::vector<double>& values) {
    written_.write(step, tracer_.output.size(), [&](std::size_t i) {
      if (tracer_.output[i] == TableFormat::csv)
        write_csv(step, lines, cells, columns, values);
      else
        write_vtp(step, lines, VtkColumns(columns, values));
    });
  }

  void write_csv(const Step& step, const advect::Polylines& lines, const Cells& cells,
                 const std::vector<std::string>& columns, const std::vector<double>& values) {
    const CellNames& names = cells.names;
    std::vector<std::string> header{"line", "vertex", "s", "x", "y", "z", "cell"};
    if (names.pieces)
      header.push_back("piece");
    if (names.processes)
      header.push_back("process");
    header.push_back("ending");
    header.insert(header.end(), columns.begin(), columns.end());
    output::CsvRows rows(header.size());
    for (std::size_t l = 0; l < lines.line_count(); ++l)
      for (auto v = std::size_t(lines.offsets[l]); v < std::size_t(lines.offsets[l + 1]); ++v) {
        rows.cell(lines.particles[l]).cell(std::int64_t(v) - lines.offsets[l]);
        rows.cell(core::unsigned_zero(lines.times[v]));
        for (int a = 0; a < 3; ++a)
          rows.cell(core::unsigned_zero(lines.points[v][a]));
        const OwnCell& own = cells.of[v];
        rows.cell(names.cell(own));
        if (names.pieces)
          rows.cell(int(own.piece));
        if (names.processes)
          rows.cell(int(own.process));
        rows.cell(advect::ending_name(insitu_ending(lines.endings[l])));
        for (std::size_t c = 0; c < columns.size(); ++c)
          rows.cell(values[v * columns.size() + c]);
        rows.end_row();
      }
    output::write_csv(cycle_path(environment_, tracer_.name, step.cycle, ".csv"), header, rows);
    ++environment_.statistics.files;
  }

  void write_vtp(const Step& step, const advect::Polylines& lines, const VtkColumns& columns) {
    const DrawnLines drawn(lines);
    output::VtkPolyData data;
    data.points = vtk_points(lines.points.span());
    data.point_data.push_back(output::vtk_array("s", lines.times.span()));
    columns.add_to(data.point_data);
    drawn.add_to(data, "line");
    series_.write(environment_, tracer_.name, step, data);
  }

  advect::Counts counts_, counts_before_; ///< before the step
  StepNote note_;
  Formats written_;
  TracerCells cells_{environment_.context.memory};
  VtpSeries series_;
};

/// Each process has the rows of what was traced there; the root puts the lines together and writes.
void StreamTracer::execute_across(commit::CommittedMesh& mesh, const Step& step) {
  const core::Timer timer;
  parallel::World& world = environment_.world;
  core::Context& context = environment_.context;
  mesh.update_halo(world, context.threads, context.log);
  const std::vector<mesh::FieldView> velocity =
      find_fields(mesh, {&tracer_.velocity, 1}, environment_.scene_file, world);
  const std::vector<mesh::FieldView> recorded =
      find_fields(mesh, tracer_.fields, environment_.scene_file, world);
  const CellNames names = name_cells(mesh.mesh(), world);
  const std::vector<math::Vec3d>& points = seeds_of_all(mesh);
  advect::StreamlineSettings settings = line_settings();
  std::optional<query::Sampler> sampler;
  const auto left_out = [&] { return cells_.left_out(mesh, context.threads); };
  std::optional<advect::Exits> exits;
  world.agree_after([&] {
    settings.effects = effects_at(tracer_, mesh, step, 0, environment_.scene_file);
    if (mesh.mesh().own_view().own_cell_count() > 0) {
      mesh.look_for_folds(context.threads); // particles ask with hints
      mesh.find_neighbours_if_due(context.threads);
    }
    sampler = cells_.sampler(mesh, velocity, context.threads);
    exits.emplace(mesh.sampler(), left_out, settings.accuracy);
    settings.exits = &*exits;
  });
  const MeshHomes homes(mesh);
  const advect::LinePieces here =
      advect::trace_lines_across({world, homes}, *sampler, velocity.front(), points, settings,
                                 context.threads, context.memory);
  counts_ += here.counts;
  environment_.statistics.advect_s += timer.seconds();
  const core::Timer output_timer;
  const GatheredLines all(here, *this, mesh, recorded, world, context.memory,
                          settings.direction == advect::Direction::both ? 2 : 1);
  world.agree_after([&] {
    if (!world.is_root())
      return;
    const std::vector<std::string> columns = field_columns(recorded);
    write(step, all.lines, {names, all.cells}, columns, all.values);
  });
  environment_.statistics.output_s += output_timer.seconds();
}

} // namespace

std::unique_ptr<TracerAction> make_stream_tracer(const Tracer& tracer,
                                                 const Environment& environment) {
  return std::make_unique<StreamTracer>(tracer, environment);
}

} // namespace insitu::scene

#include "core/timer.h"
#include "scene/tracer_action.h"
#include "scene/vtp_series.h"

namespace insitu::scene {

namespace {

std::span<const std::int64_t> line_ends(const advect::Polylines& lines) {
  return lines.offsets.span().subspan(lines.line_count() ? 1 : lines.offsets.size());
}

/// Pathlines and streaklines: particles that live from cycle to cycle.
class PathTracer final : public TracerAction {
public:
  PathTracer(const Tracer& tracer, const Environment& environment)
      : TracerAction(tracer, environment), particles_(settings(), environment.context.memory),
        tracks_(environment.context.memory) {}

  advect::Counts counts() const override { return particles_.counts(); }

  std::string needs_earlier() const override {
    return particles_.counts().alive() > 0 || tracer_.kind == TracerKind::streakline
               ? tracer_.velocity.text
               : std::string();
  }

  void execute(query::CommittedMesh& mesh, const Step& step, bool due) override {
    const core::Timer timer;
    core::Context& context = environment_.context;
    const mesh::FieldView velocity = find_field(mesh, tracer_.velocity, environment_.scene_file);
    if (!seeded_) {
      particles_.seed(seeds(mesh), step.time);
      seeded_ = true;
      settled_ = step.time;
    } else if (tracer_.kind == TracerKind::streakline) { // every cycle releases its own
      particles_.seed(seeds(mesh), step.time);
    }
    // The earlier step serves if it is the step that the particles are at, on the same cells.
    const bool earlier_is_known =
        topology_ == mesh.topology_version() && !step.first && settled_ == step.earlier_time;
    const auto earlier =
        earlier_is_known ? mesh.mesh().earlier_field(tracer_.velocity.text) : std::nullopt;
    mesh.mesh().expose_earlier(earlier.has_value(), context.threads);
    const auto hide = [&] { mesh.mesh().expose_earlier(false, context.threads); };
    try {
      particles_.advance(mesh.sampler(), velocity, earlier ? &*earlier : nullptr, settled_,
                         step.time, context.threads);
    } catch (...) {
      hide();
      throw;
    }
    hide();
    settled_ = step.time;
    topology_ = mesh.topology_version();
    if (due && writes(TableFormat::vtp))
      tracks_.record(particles_.particles());
    environment_.statistics.advect_s += timer.seconds();
    if (due)
      write(mesh, step);
  }

  void finish() override {
    particles_.finish();
    if (table_)
      table_->flush();
    table_.reset();
  }

private:
  advect::TracerSettings settings() const {
    advect::TracerSettings s;
    s.integrator = integrator();
    s.accuracy = to_api(tracer_.accuracy);
    if (tracer_.until.duration)
      s.duration = *tracer_.until.duration;
    if (tracer_.until.length)
      s.length = *tracer_.until.length;
    return s;
  }

  void write(const query::CommittedMesh& mesh, const Step& step) {
    const core::Timer timer;
    if (writes(TableFormat::csv))
      write_table(mesh, step);
    if (writes(TableFormat::vtp)) {
      write_particles(mesh, step);
      write_tracks(step);
    }
    environment_.statistics.output_s += timer.seconds();
  }

  void write_table(const query::CommittedMesh& mesh, const Step& step) {
    const std::vector<mesh::FieldView> recorded = fields(mesh);
    const std::vector<std::string> columns = field_columns(recorded);
    if (!table_) {
      std::vector<std::string> header{"cycle", "time", "particle", "x", "y", "z", "cell", "ending"};
      header.insert(header.end(), columns.begin(), columns.end());
      table_ = std::make_unique<output::AppendTable>(
          environment_.output + "/" + tracer_.name + ".csv", std::move(header), step.cycle);
      ++environment_.statistics.files;
    }
    const advect::Particles& p = particles_.particles();
    const std::vector<double> values = sample(mesh, recorded, p.positions.span(), p.cells.span());
    const std::size_t width = columns.size();
    written_.resize(std::size_t(particles_.counts().seeded), 0);
    for (std::size_t i = 0; i < p.size(); ++i) {
      const auto id = std::size_t(p.ids[i]);
      if (written_[id])
        continue; // its last row stands
      written_[id] = p.endings[i] != INSITU_END_ALIVE;
      output::CsvRows& row = table_->rows();
      row.cell(step.cycle).cell(p.times[i]).cell(p.ids[i]);
      row.cell(p.positions[i].x).cell(p.positions[i].y).cell(p.positions[i].z).cell(p.cells[i]);
      row.cell(advect::ending_name(insitu_ending(p.endings[i])));
      for (std::size_t c = 0; c < width; ++c)
        row.cell(values[i * width + c]);
      row.end_row();
    }
    table_->flush();
  }

  /// The particles as they are now, ended ones where they ended; indexed by time.
  void write_particles(const query::CommittedMesh& mesh, const Step& step) {
    const advect::Particles& p = particles_.particles();
    const std::vector<mesh::FieldView> recorded = fields(mesh);
    const VtkColumns columns(field_columns(recorded),
                             sample(mesh, recorded, p.positions.span(), p.cells.span()));
    output::VtkPolyData data;
    data.points = vtk_points(p.positions.span());
    data.point_data.push_back(output::vtk_array("particle", p.ids.span()));
    data.point_data.push_back(output::vtk_array("cell", p.cells.span()));
    data.point_data.push_back(output::vtk_array("ending", p.endings.span()));
    columns.add_to(data.point_data);
    series_.write(environment_, tracer_.name, step, data);
  }

  /// All tracks so far, a vertex for each cycle at which the tracer was due; one file, rewritten.
  void write_tracks(const Step& step) {
    const advect::Polylines lines = tracks_.lines();
    output::VtkPolyData data;
    data.points = vtk_points(lines.points.span());
    data.point_data.push_back(output::vtk_array("time", lines.times.span()));
    data.cell_data.push_back(output::vtk_array("particle", lines.particles.span()));
    data.cell_data.push_back(output::vtk_array("ending", lines.endings.span()));
    data.line_ends = line_ends(lines);
    data.has_time = true;
    data.time = step.time;
    output::write_vtp(environment_.output + "/" + tracer_.name + "_tracks.vtp", data);
    ++environment_.statistics.files;
  }

  advect::Tracer particles_;
  advect::Tracks tracks_;
  bool seeded_ = false;
  double settled_ = 0.0; ///< the time that the particles are at
  std::uint64_t topology_ = 0;
  std::vector<std::uint8_t> written_; ///< [id] 1: the row of its ending is in the table
  std::unique_ptr<output::AppendTable> table_;
  VtpSeries series_;
};

/// Streamlines of the velocity as it is when due.
class StreamTracer final : public TracerAction {
public:
  using TracerAction::TracerAction;

  advect::Counts counts() const override { return counts_; }

  void execute(query::CommittedMesh& mesh, const Step& step, bool due) override {
    if (!due)
      return;
    const core::Timer timer;
    advect::StreamlineSettings settings;
    settings.integrator = integrator();
    settings.accuracy = to_api(tracer_.accuracy);
    if (tracer_.until.duration)
      settings.duration = *tracer_.until.duration;
    if (tracer_.until.length)
      settings.length = *tracer_.until.length;
    const advect::Streamlines streamlines = advect::trace_streamlines(
        mesh.sampler(), find_field(mesh, tracer_.velocity, environment_.scene_file), seeds(mesh),
        settings, environment_.context.threads, environment_.context.memory);
    counts_ += streamlines.counts;
    environment_.statistics.advect_s += timer.seconds();
    const core::Timer output_timer;
    const advect::Polylines& lines = streamlines.lines;
    const std::vector<mesh::FieldView> recorded = fields(mesh);
    const std::vector<std::string> columns = field_columns(recorded);
    const std::vector<double> values =
        sample(mesh, recorded, lines.points.span(), lines.cells.span());
    if (writes(TableFormat::csv))
      write_csv(step, lines, columns, values);
    if (writes(TableFormat::vtp))
      write_vtp(step, lines, VtkColumns(columns, values));
    environment_.statistics.output_s += output_timer.seconds();
  }

private:
  void write_csv(const Step& step, const advect::Polylines& lines,
                 const std::vector<std::string>& columns, const std::vector<double>& values) {
    std::vector<std::string> header{"line", "vertex", "s", "x", "y", "z", "cell", "ending"};
    header.insert(header.end(), columns.begin(), columns.end());
    output::CsvRows rows(header.size());
    for (std::size_t l = 0; l < lines.line_count(); ++l)
      for (auto v = std::size_t(lines.offsets[l]); v < std::size_t(lines.offsets[l + 1]); ++v) {
        rows.cell(lines.particles[l]).cell(std::int64_t(v) - lines.offsets[l]);
        rows.cell(lines.times[v]).cell(lines.points[v].x).cell(lines.points[v].y);
        rows.cell(lines.points[v].z).cell(lines.cells[v]);
        rows.cell(advect::ending_name(insitu_ending(lines.endings[l])));
        for (std::size_t c = 0; c < columns.size(); ++c)
          rows.cell(values[v * columns.size() + c]);
        rows.end_row();
      }
    output::write_csv(cycle_path(environment_, tracer_.name, step.cycle, ".csv"), header, rows);
    ++environment_.statistics.files;
  }

  void write_vtp(const Step& step, const advect::Polylines& lines, const VtkColumns& columns) {
    output::VtkPolyData data;
    data.points = vtk_points(lines.points.span());
    data.point_data.push_back(output::vtk_array("s", lines.times.span()));
    columns.add_to(data.point_data);
    data.cell_data.push_back(output::vtk_array("line", lines.particles.span()));
    data.cell_data.push_back(output::vtk_array("ending", lines.endings.span()));
    data.line_ends = line_ends(lines);
    series_.write(environment_, tracer_.name, step, data);
  }

  advect::Counts counts_;
  VtpSeries series_;
};

} // namespace

std::unique_ptr<TracerAction> make_tracer_action(const Tracer& tracer,
                                                 const Environment& environment) {
  if (tracer.kind == TracerKind::streamline)
    return std::make_unique<StreamTracer>(tracer, environment);
  return std::make_unique<PathTracer>(tracer, environment);
}

} // namespace insitu::scene

#include "core/timer.h"
#include "scene/tracer_action.h"

namespace insitu::scene {

namespace {

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
    const mesh::FieldView velocity =
        find_field(mesh, tracer_.velocity, environment_.scene_file);
    if (!seeded_) {
      particles_.seed(seeds(mesh), step.time);
      seeded_ = true;
      settled_ = step.time;
    } else if (tracer_.kind == TracerKind::streakline && due) {
      particles_.seed(seeds(mesh), step.time);
    }
    // The earlier step serves if it is the step that the particles are at, on the same cells.
    const bool earlier_is_known =
        topology_ == mesh.topology_version() && !step.first && settled_ == step.earlier_time;
    const auto earlier = earlier_is_known ? mesh.mesh().earlier_field(tracer_.velocity.text)
                                          : std::nullopt;
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
    const std::size_t first_new = due || writes(TableFormat::vtp)
                                      ? tracks_.record(particles_.particles())
                                      : tracks_.size();
    environment_.statistics.advect_s += timer.seconds();
    if (due)
      write(mesh, step, first_new);
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

  void write(const query::CommittedMesh& mesh, const Step& step, std::size_t first_new) {
    const core::Timer timer;
    if (writes(TableFormat::csv))
      write_table(mesh, step);
    if (writes(TableFormat::vtp))
      write_vtp(step);
    else if (first_new < tracks_.size())
      tracks_ = advect::Tracks(environment_.context.memory); // the table has it; nothing else reads it
    environment_.statistics.output_s += timer.seconds();
  }

  void write_table(const query::CommittedMesh& mesh, const Step& step) {
    const std::vector<mesh::FieldView> recorded = fields(mesh);
    const std::vector<std::string> columns = field_columns(recorded);
    if (!table_) {
      std::vector<std::string> header{"cycle", "time", "particle", "x", "y", "z", "cell", "ending"};
      header.insert(header.end(), columns.begin(), columns.end());
      table_ = std::make_unique<output::AppendTable>(
          environment_.output + "/" + tracer_.name + ".csv", std::move(header));
      ++environment_.statistics.files;
    }
    const advect::Particles& p = particles_.particles();
    const std::vector<double> values =
        sample(mesh, recorded, p.positions.span(), p.cells.span());
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

  void write_vtp(const Step& step) {
    const advect::Polylines lines = tracks_.lines();
    const std::size_t n = lines.line_count();
    output::VtkPolyData data;
    data.points = output::vtk_array(
        "points", std::span<const double>(n ? &lines.points[0].x : nullptr,
                                          3 * lines.vertex_count()), 3);
    data.point_data.push_back(output::vtk_array("time", lines.times.span()));
    data.cell_data.push_back(output::vtk_array("particle", lines.particles.span()));
    data.cell_data.push_back(output::vtk_array("ending", lines.endings.span()));
    data.line_ends = lines.offsets.span().subspan(n ? 1 : lines.offsets.size());
    data.has_time = true;
    data.time = step.time;
    const std::string path = cycle_path(environment_, tracer_.name, step.cycle, ".vtp");
    output::write_vtp(path, data);
    ++environment_.statistics.files;
    if (!series_)
      series_ =
          std::make_unique<output::PvdSeries>(environment_.output + "/" + tracer_.name + ".pvd");
    series_->add(step.time, path.substr(environment_.output.size() + 1));
  }

  advect::Tracer particles_;
  advect::Tracks tracks_;
  bool seeded_ = false;
  double settled_ = 0.0; ///< the time that the particles are at
  std::uint64_t topology_ = 0;
  std::vector<std::uint8_t> written_; ///< [id] 1: the row of its ending is in the table
  std::unique_ptr<output::AppendTable> table_;
  std::unique_ptr<output::PvdSeries> series_;
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
      write_vtp(step, lines, columns, values);
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

  void write_vtp(const Step& step, const advect::Polylines& lines,
                 const std::vector<std::string>& columns, const std::vector<double>& values) {
    const std::size_t n = lines.vertex_count(), width = columns.size();
    std::vector<std::vector<double>> data_columns(width, std::vector<double>(n));
    for (std::size_t c = 0; c < width; ++c)
      for (std::size_t i = 0; i < n; ++i)
        data_columns[c][i] = values[i * width + c];
    output::VtkPolyData data;
    data.points = output::vtk_array(
        "points", std::span<const double>(n ? &lines.points[0].x : nullptr, 3 * n), 3);
    data.point_data.push_back(output::vtk_array("s", lines.times.span()));
    for (std::size_t c = 0; c < width; ++c)
      data.point_data.push_back(
          output::vtk_array(columns[c], std::span<const double>(data_columns[c])));
    data.cell_data.push_back(output::vtk_array("line", lines.particles.span()));
    data.cell_data.push_back(output::vtk_array("ending", lines.endings.span()));
    data.line_ends = lines.offsets.span().subspan(lines.line_count() ? 1 : lines.offsets.size());
    data.has_time = true;
    data.time = step.time;
    const std::string path = cycle_path(environment_, tracer_.name, step.cycle, ".vtp");
    output::write_vtp(path, data);
    ++environment_.statistics.files;
    if (!series_)
      series_ =
          std::make_unique<output::PvdSeries>(environment_.output + "/" + tracer_.name + ".pvd");
    series_->add(step.time, path.substr(environment_.output.size() + 1));
  }

  advect::Counts counts_;
  std::unique_ptr<output::PvdSeries> series_;
};

} // namespace

std::unique_ptr<TracerAction> make_tracer_action(const Tracer& tracer,
                                                 const Environment& environment) {
  if (tracer.kind == TracerKind::streamline)
    return std::make_unique<StreamTracer>(tracer, environment);
  return std::make_unique<PathTracer>(tracer, environment);
}

} // namespace insitu::scene

#include "core/status.h"
#include "core/timer.h"
#include "scene/tracer_action.h"
#include "scene/vtp_series.h"

namespace insitu::scene {

namespace {

/// The lines that have a vertex, for VTK files: those of seeds outside have none, and only end in
/// the tables and reports.
struct DrawnLines {
  explicit DrawnLines(const advect::Polylines& lines) {
    for (std::size_t l = 0; l < lines.line_count(); ++l) {
      if (lines.offsets[l] == lines.offsets[l + 1])
        continue;
      ends.push_back(lines.offsets[l + 1]);
      particles.push_back(lines.particles[l]);
      endings.push_back(lines.endings[l]);
    }
  }
  void add_to(output::VtkPolyData& data, const char* particle_name) const {
    data.cell_data.push_back(
        output::vtk_array(particle_name, std::span<const std::int64_t>(particles)));
    data.cell_data.push_back(output::vtk_array("ending", std::span<const std::uint8_t>(endings)));
    data.line_ends = ends;
  }
  std::vector<std::int64_t> ends, particles;
  std::vector<std::uint8_t> endings;
};

/// The cells of points as the solver numbers them, for VTK files.
struct OwnCells {
  OwnCells(const query::CommittedMesh& mesh, std::span<const std::int64_t> flat,
           std::span<const math::Vec3d> points)
      : several(mesh.mesh().own_view().piece_count > 1) {
    for (std::size_t i = 0; i < flat.size(); ++i) {
      const OwnCell own = own_cell(mesh, flat[i], points[i]);
      cells.push_back(own.cell);
      pieces.push_back(own.piece);
    }
  }
  void add_to(std::vector<output::VtkArray>& arrays) const {
    arrays.push_back(output::vtk_array("cell", std::span<const std::int64_t>(cells)));
    if (several)
      arrays.push_back(output::vtk_array("piece", std::span<const std::int32_t>(pieces)));
  }
  bool several;
  std::vector<std::int64_t> cells;
  std::vector<std::int32_t> pieces;
};

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
    } else if (!(step.time >= settled_)) {
      throw core::Error(INSITU_ERROR_ARGUMENT, "time went back from " + std::to_string(settled_) +
                                                   " to " + std::to_string(step.time) +
                                                   "; the particles wait where they are");
    } else if (tracer_.kind == TracerKind::streakline) { // every cycle releases its own
      particles_.seed(seeds(mesh), step.time);
    }
    // The earlier step serves if it is the step that the particles are at, on the same cells.
    const bool earlier_is_known =
        topology_ == mesh.topology_version() && !step.first && settled_ == step.earlier_time;
    const auto earlier =
        earlier_is_known ? mesh.mesh().earlier_field(tracer_.velocity.text) : std::nullopt;
    mesh.look_for_folds(context.threads); // particles ask with hints
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
    const core::Timer output_timer;
    last_ = {step.cycle, step.time};
    if (writes(TableFormat::csv))
      write_table(mesh, step, due);
    if (due && writes(TableFormat::vtp)) {
      write_particles(mesh, step);
      write_tracks();
    } else if (!writes(TableFormat::vtp)) {
      particles_.drop_ended(); // in the table, and needed no more
    }
    environment_.statistics.output_s += output_timer.seconds();
  }

  /// The solver's arrays may be gone: what needs no field is written.
  void finish() override {
    particles_.finish();
    if (!seeded_)
      return;
    if (writes(TableFormat::vtp)) {
      tracks_.record(particles_.particles());
      write_tracks();
    }
    if (writes(TableFormat::csv) && table_) {
      const advect::Particles& p = particles_.particles();
      written_.resize(std::size_t(particles_.counts().seeded), 0);
      for (std::size_t i = 0; i < p.size(); ++i)
        if (!written_[std::size_t(p.ids[i])])
          add_row(i, OwnCell{}, {});
      table_->flush();
    }
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

  /// Rows of the particles that have ended since the last call and, when due, of the living.
  void write_table(const query::CommittedMesh& mesh, const Step& step, bool due) {
    const advect::Particles& p = particles_.particles();
    written_.resize(std::size_t(particles_.counts().seeded), 0);
    std::vector<std::size_t> rows;
    std::vector<math::Vec3d> points;
    std::vector<std::int64_t> cells;
    for (std::size_t i = 0; i < p.size(); ++i)
      if (!written_[std::size_t(p.ids[i])] && (due || p.endings[i] != INSITU_END_ALIVE)) {
        rows.push_back(i);
        points.push_back(p.positions[i]);
        cells.push_back(p.cells[i]);
      }
    if (rows.empty() && !due)
      return;
    const std::vector<mesh::FieldView> recorded = fields(mesh);
    const std::vector<double> values = sample(mesh, recorded, points, cells);
    open_table(mesh, recorded, step);
    const std::size_t width = rows.empty() ? 0 : values.size() / rows.size();
    for (std::size_t r = 0; r < rows.size(); ++r) {
      add_row(rows[r], own_cell(mesh, cells[r], points[r]),
              std::span(values).subspan(r * width, width));
      written_[std::size_t(p.ids[rows[r]])] = p.endings[rows[r]] != INSITU_END_ALIVE;
    }
    if (due)
      flush_table(*table_);
  }

  void open_table(const query::CommittedMesh& mesh, std::span<const mesh::FieldView> recorded,
                  const Step& step) {
    std::vector<std::string> columns{"cycle", "time", "particle", "x", "y", "z", "cell"};
    const bool several = mesh.mesh().own_view().piece_count > 1;
    if (several)
      columns.push_back("piece");
    columns.push_back("ending");
    for (std::string& c : field_columns(recorded))
      columns.push_back(std::move(c));
    if (table_) {
      require_columns(*table_, columns_, columns);
      return;
    }
    table_ = std::make_unique<output::AppendTable>(
        environment_.output + "/" + tracer_.name + ".csv", columns, step.cycle);
    ++environment_.statistics.files;
    columns_ = std::move(columns);
    several_ = several;
  }

  /// values: of the fields, or nothing if they are not known.
  void add_row(std::size_t i, const OwnCell& own, std::span<const double> values) {
    const advect::Particles& p = particles_.particles();
    output::CsvRows& row = table_->rows();
    row.cell(last_.cycle).cell(p.times[i]).cell(p.ids[i]);
    row.cell(p.positions[i].x).cell(p.positions[i].y).cell(p.positions[i].z).cell(own.cell);
    if (several_)
      row.cell(int(own.piece));
    row.cell(advect::ending_name(insitu_ending(p.endings[i])));
    const std::size_t first = several_ ? 9 : 8;
    for (std::size_t c = first; c < columns_.size(); ++c)
      row.cell(values.empty() ? std::numeric_limits<double>::quiet_NaN() : values[c - first]);
    row.end_row();
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
    const OwnCells cells(mesh, p.cells.span(), p.positions.span());
    cells.add_to(data.point_data);
    data.point_data.push_back(output::vtk_array("ending", p.endings.span()));
    columns.add_to(data.point_data);
    series_.write(environment_, tracer_.name, step, data);
  }

  /// All tracks so far, a vertex for each cycle at which the tracer was due and one where a
  /// particle ended; one file, rewritten.
  void write_tracks() {
    const advect::Polylines lines = tracks_.lines();
    const DrawnLines drawn(lines);
    output::VtkPolyData data;
    data.points = vtk_points(lines.points.span());
    data.point_data.push_back(output::vtk_array("time", lines.times.span()));
    drawn.add_to(data, "particle");
    data.has_time = true;
    data.time = last_.time;
    output::write_vtp(environment_.output + "/" + tracer_.name + "_tracks.vtp", data);
    ++environment_.statistics.files;
  }

  advect::Tracer particles_;
  advect::Tracks tracks_;
  bool seeded_ = false;
  double settled_ = 0.0; ///< the time that the particles are at
  std::uint64_t topology_ = 0;
  struct {
    std::int64_t cycle = 0;
    double time = 0.0;
  } last_;                            ///< the last execution
  std::vector<std::uint8_t> written_; ///< [id] 1: the row of its ending is in the table
  std::unique_ptr<output::AppendTable> table_;
  std::vector<std::string> columns_; ///< of the table
  bool several_ = false;             ///< the table has a column for pieces
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
    settings.direction = tracer_.direction == TracerDirection::both ? advect::Direction::both
                         : tracer_.direction == TracerDirection::backward
                             ? advect::Direction::backward
                             : advect::Direction::forward;
    settings.accuracy = to_api(tracer_.accuracy);
    if (tracer_.until.duration)
      settings.duration = *tracer_.until.duration;
    if (tracer_.until.length)
      settings.length = *tracer_.until.length;
    mesh.look_for_folds(environment_.context.threads); // particles ask with hints
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
      write_csv(mesh, step, lines, columns, values);
    if (writes(TableFormat::vtp))
      write_vtp(step, lines, VtkColumns(columns, values));
    environment_.statistics.output_s += output_timer.seconds();
  }

private:
  void write_csv(const query::CommittedMesh& mesh, const Step& step, const advect::Polylines& lines,
                 const std::vector<std::string>& columns, const std::vector<double>& values) {
    const bool several = mesh.mesh().own_view().piece_count > 1;
    std::vector<std::string> header{"line", "vertex", "s", "x", "y", "z", "cell"};
    if (several)
      header.push_back("piece");
    header.push_back("ending");
    header.insert(header.end(), columns.begin(), columns.end());
    output::CsvRows rows(header.size());
    for (std::size_t l = 0; l < lines.line_count(); ++l)
      for (auto v = std::size_t(lines.offsets[l]); v < std::size_t(lines.offsets[l + 1]); ++v) {
        rows.cell(lines.particles[l]).cell(std::int64_t(v) - lines.offsets[l]);
        rows.cell(lines.times[v]).cell(lines.points[v].x).cell(lines.points[v].y);
        const OwnCell own = own_cell(mesh, lines.cells[v], lines.points[v]);
        rows.cell(lines.points[v].z).cell(own.cell);
        if (several)
          rows.cell(int(own.piece));
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

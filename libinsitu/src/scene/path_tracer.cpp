#include <algorithm>

#include "core/status.h"
#include "core/timer.h"
#include "scene/release.h"
#include "scene/tracer_action.h"
#include "scene/tracer_effects.h"
#include "scene/track_writer.h"

namespace insitu::scene {

namespace {

/// Pathlines and streaklines: particles that live from cycle to cycle. How they move is here; how
/// they are written is the writers'.
class PathTracer final : public TracerAction {
public:
  PathTracer(const Tracer& tracer, const Environment& environment)
      : TracerAction(tracer, environment), particles_(settings(), environment.context.memory),
        clock_(tracer.release), geodesics_(tracer.geodesics, environment.context.memory) {
    for (const TableFormat format : tracer_.output)
      writers_.push_back(make_track_writer(format, tracer_, environment_));
  }

  advect::Counts counts() const override { return particles_.counts(); }

  std::vector<std::string> needs_earlier() const override {
    if (tracer_.attached == Attached::body ||
        (particles_.counts().alive() == 0 && !clock_.goes_on(last_.time)))
      return {};
    std::vector<std::string> names = effect_fields(tracer_.effects);
    names.push_back(tracer_.velocity.text);
    return names;
  }

  void execute(query::CommittedMesh& mesh, const Step& step, bool due) override {
    const core::Timer timer;
    if (!tracer_.geodesics.empty() && mesh.frame.kind == INSITU_FRAME_CARTESIAN)
      throw core::Error(INSITU_ERROR_SCENE,
                        environment_.scene_file + ":" + std::to_string(tracer_.line) +
                            ": geodesics need a mesh with a place on Earth; the "
                            "frame of this one is cartesian");
    if (tracer_.attached == Attached::body) {
      release(mesh, step);
      particles_.follow(mesh.sampler(), knows_cells(mesh), settled_, step.time,
                        environment_.context.threads);
      settled_ = step.time;
      topology_ = mesh.topology_version();
      same_cells_ = false;
    } else {
      const mesh::FieldView velocity = find_field(mesh, tracer_.velocity, environment_.scene_file);
      // The earlier step serves if it is the step that the particles are at, on the same cells.
      const bool earlier =
          seeded_ && knows_cells(mesh) && !step.first && settled_ == step.earlier_time;
      particles_.set_effects(effects_at(tracer_, mesh, step, earlier, environment_.scene_file));
      release(mesh, step);
      advance(mesh, velocity, step);
    }
    geodesics_.follow(particles_.particles(), mesh.frame, environment_.context.threads);
    environment_.statistics.advect_s += timer.seconds();
    const core::Timer output_timer;
    last_ = {step.cycle, step.time};
    write(mesh, step, due);
    environment_.statistics.output_s += output_timer.seconds();
  }

  void keep(core::Archive& archive, std::int64_t cycle) override {
    archive.value("executed", seeded_);
    archive.value("time of particles", settled_);
    archive.value("last cycle", last_.cycle);
    archive.value("last time", last_.time);
    ReleaseClock::State clock = clock_.state();
    archive.value("begun", clock.begun);
    archive.value("first release", clock.first);
    archive.value("releases", clock.rounds);
    clock_.set_state(clock);
    particles_.keep(archive);
    geodesics_.keep(archive);
    for (const auto& writer : writers_)
      writer->keep(archive, cycle);
  }
  void take_up(bool same_cells) override { same_cells_ = same_cells; }

  /// The solver's arrays may be gone: what needs no field is written.
  void finish() override {
    particles_.finish();
    if (!seeded_)
      return;
    Failures failures;
    for (const auto& writer : writers_)
      failures.catch_of(
          [&] { writer->finish(particles_.particles(), geodesics_, last_.cycle, last_.time); });
    failures.throw_if_any();
  }

private:
  advect::TracerSettings settings() const {
    advect::TracerSettings s;
    s.integrator = integrator();
    s.accuracy = to_api(tracer_.accuracy);
    s.attached = tracer_.attached == Attached::body;
    if (tracer_.until.duration)
      s.duration = *tracer_.until.duration;
    if (tracer_.effects.age_limit)
      s.duration = std::min(s.duration, *tracer_.effects.age_limit);
    if (tracer_.until.length)
      s.length = *tracer_.until.length;
    return s;
  }

  /// Whether the mesh's cells are those of the step that the particles are at.
  bool knows_cells(const query::CommittedMesh& mesh) const {
    return topology_ == mesh.topology_version() || same_cells_;
  }

  bool may_release(const query::CommittedMesh& mesh, const Step& step) const {
    const Release& release = tracer_.release;
    return !release.when ||
           release.when->evaluate(
               step.cycle, step.time, [&](Reduction reduction, const std::string& field) {
                 return reduce_field(mesh, {field, release.line}, environment_.scene_file,
                                     reduction, environment_.context.threads);
               });
  }

  /// Adds the particles that begin between the last step and this one.
  void release(const query::CommittedMesh& mesh, const Step& step) {
    if (seeded_ && !(step.time >= settled_))
      throw core::Error(INSITU_ERROR_ARGUMENT, "time went back from " + std::to_string(settled_) +
                                                   " to " + std::to_string(step.time) +
                                                   "; the particles wait where they are");
    const std::vector<double> times = clock_.due(step.cycle, step.time);
    if (!times.empty() && may_release(mesh, step)) {
      const std::vector<math::Vec3d>& points = seeds(mesh);
      for (const double time : times)
        particles_.seed(points, time);
      clock_.note(step.time, times.size());
    } else {
      clock_.pass(step.time, times.size());
    }
    if (!seeded_)
      settled_ = step.time;
    seeded_ = true;
    geodesics_.begin(particles_.particles(), mesh.frame);
  }

  void advance(query::CommittedMesh& mesh, const mesh::FieldView& velocity, const Step& step) {
    core::Context& context = environment_.context;
    // The earlier step serves if it is the step that the particles are at, on the same cells.
    const bool earlier_is_known = knows_cells(mesh) && !step.first && settled_ == step.earlier_time;
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
    same_cells_ = false;
  }

  /// What the writers see of a cycle. The rows that one asked for last are kept: the next one, of
  /// another format, mostly asks for the same.
  class Cycle final : public TrackCycle {
  public:
    Cycle(PathTracer& tracer, const query::CommittedMesh& mesh, const Step& step, bool due)
        : tracer_(tracer), mesh_(mesh), step_(step), due_(due) {}
    const Step& step() const override { return step_; }
    bool due() const override { return due_; }
    const advect::Particles& particles() const override { return tracer_.particles_.particles(); }
    std::int64_t seeded() const override { return particles().seeded(); }
    const TrackGeodesics& geodesics() const override { return tracer_.geodesics_; }
    const TrackRows& rows(const std::vector<std::size_t>& indices) override {
      if (!known_ || *known_ != indices) {
        rows_ = tracer_.rows(mesh_, step_, indices);
        known_ = indices;
      }
      return rows_;
    }

  private:
    PathTracer& tracer_;
    const query::CommittedMesh& mesh_;
    const Step& step_;
    bool due_;
    std::optional<std::vector<std::size_t>> known_;
    TrackRows rows_;
  };

  TrackRows rows(const query::CommittedMesh& mesh, const Step& step,
                 const std::vector<std::size_t>& indices) const {
    const advect::Particles& p = particles_.particles();
    std::vector<math::Vec3d> points;
    std::vector<std::int64_t> cells;
    for (const std::size_t i : indices) {
      points.push_back(p.positions[i]);
      cells.push_back(p.cells[i]);
    }
    const std::vector<mesh::FieldView> recorded = fields(mesh);
    TrackRows out;
    out.cycle = step.cycle;
    out.pieces = mesh.mesh().own_view().piece_count > 1;
    out.frame = mesh.frame;
    out.columns = field_columns(recorded);
    out.values = sample(mesh, recorded, points, cells);
    add_geodesics(out, p, indices);
    for (std::size_t r = 0; r < indices.size(); ++r) {
      const std::size_t i = indices[r];
      out.rows.push_back({p.ids[i], p.times[i], points[r], own_cell(mesh, cells[r], points[r]),
                          insitu_ending(p.endings[i])});
    }
    return out;
  }

  /// Further columns after those of the fields.
  void add_geodesics(TrackRows& out, const advect::Particles& p,
                     const std::vector<std::size_t>& indices) const {
    const std::size_t fields = out.columns.size(), width = fields + geodesics_.columns().size();
    if (width == fields)
      return;
    for (const TrackGeodesic column : geodesics_.columns())
      out.columns.emplace_back(geodesic_name(column));
    std::vector<double> values(indices.size() * width);
    for (std::size_t r = 0; r < indices.size(); ++r) {
      std::copy_n(out.values.data() + r * fields, fields, values.data() + r * width);
      geodesics_.put(p.ids[indices[r]], values.data() + r * width + fields);
    }
    out.values = std::move(values);
  }

  void write(const query::CommittedMesh& mesh, const Step& step, bool due) {
    Cycle cycle(*this, mesh, step, due);
    Failures failures;
    bool keep = false;
    for (const auto& writer : writers_) {
      failures.catch_of([&] { writer->write(cycle); });
      keep = keep || writer->keeps_ended();
    }
    if (!keep && !failures.any())
      particles_.drop_ended(); // in the tables, and needed no more
    failures.throw_if_any();
  }

  advect::Tracer particles_;
  ReleaseClock clock_;
  TrackGeodesics geodesics_;
  std::vector<std::unique_ptr<TrackWriter>> writers_;
  bool seeded_ = false;
  double settled_ = 0.0; ///< the time that the particles are at
  std::uint64_t topology_ = 0;
  bool same_cells_ = false; ///< as at the checkpoint of a restart
  struct {
    std::int64_t cycle = 0;
    double time = 0.0;
  } last_; ///< the last execution
};

} // namespace

std::unique_ptr<TrackWriter> make_track_writer(TableFormat format, const Tracer& tracer,
                                               const Environment& environment) {
  switch (format) {
  case TableFormat::csv:
    return make_track_csv(tracer, environment);
  case TableFormat::vtp:
    return make_track_vtp(tracer, environment);
  case TableFormat::netcdf:
    return make_track_netcdf(tracer, environment);
  case TableFormat::json:
    break;
  }
  throw core::Error(INSITU_ERROR_INTERNAL,
                    "tracer '" + tracer.name + "': no writer for this format");
}

std::unique_ptr<TracerAction> make_tracer_action(const Tracer& tracer,
                                                 const Environment& environment) {
  if (tracer.kind == TracerKind::streamline)
    return make_stream_tracer(tracer, environment);
  return std::make_unique<PathTracer>(tracer, environment);
}

} // namespace insitu::scene

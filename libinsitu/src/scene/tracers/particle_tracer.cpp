#include <algorithm>
#include <cmath>

#include "core/status.h"
#include "core/timer.h"
#include "scene/expression/reduce.h"
#include "scene/run/environment.h"
#include "scene/run/failures.h"
#include "scene/run/lookup.h"
#include "scene/run/output_times.h"
#include "scene/run/step.h"
#include "scene/tracers/field_between.h"
#include "scene/tracers/particle_cycle.h"
#include "scene/tracers/release.h"
#include "scene/tracers/tracer_action.h"
#include "scene/tracers/tracer_cells.h"
#include "scene/tracers/tracer_effects.h"
#include "scene/tracers/track_writer.h"

namespace insitu::scene {

namespace {

/// Pathlines and streaklines: particles that live from cycle to cycle. How they move is here; how
/// they are written is the writers'.
class ParticleTracer final : public TracerAction {
public:
  ParticleTracer(const Tracer& tracer, const Environment& environment)
      : TracerAction(tracer, environment), particles_(settings(), environment.context.memory),
        own_(tracer.direction == TracerDirection::backward), clock_(tracer.release, own_),
        geodesics_(tracer.geodesics, environment.context.memory),
        output_clock_(tracer.times, own_) {
    for (const TableFormat format : tracer_.output)
      writers_.push_back(make_track_writer(format, tracer_, environment_));
  }

  advect::Counts counts() const override { return particles_.counts(); }

  std::vector<mesh::KeptField> needs_earlier() const override {
    if (particles_.counts().alive() == 0 && !clock_.goes_on(last_.time))
      return {};
    const int steps = advect::steps_of(tracer_.time_interpolation) - 1;
    std::vector<mesh::KeptField> fields;
    if (tracer_.attached != Attached::body) {
      fields = effect_fields(tracer_.effects, steps);
      fields.push_back({tracer_.velocity.text, steps});
    }
    if (has_times())
      for (const Name& name : tracer_.fields)
        fields.push_back({name.text, steps});
    return fields;
  }

  bool goes_on_to_other_cells() const override { return tracer_.attached != Attached::body; }

  void execute(commit::CommittedMesh& mesh, const Step& step, bool due) override {
    const core::Timer timer;
    if (!tracer_.geodesics.empty() && mesh.reference_frame.kind == INSITU_FRAME_CARTESIAN)
      throw core::Error(INSITU_ERROR_SCENE,
                        environment_.scene_file + ":" + std::to_string(tracer_.line) +
                            ": geodesics need a mesh with a place on Earth; the "
                            "frame of this one is cartesian");
    at_times_.reset();
    due_times_ = output_clock_.due(step.time);
    if (tracer_.attached == Attached::body) {
      particles_.set_effects(effects_at(tracer_, mesh, step, 0, environment_.scene_file));
      release(mesh, step);
      begin_interval(mesh, step);
      particles_.follow(mesh.sampler(), knows_cells(mesh), settled_, step.time,
                        environment_.context.threads, snapshots());
      settled_ = step.time;
      topology_ = mesh.topology_version();
      same_cells_ = false;
    } else {
      const mesh::FieldView velocity = find_field(mesh, tracer_.velocity, environment_.scene_file);
      const int earlier = seeded_ ? earlier_steps(mesh, step) : 0;
      particles_.set_effects(effects_at(tracer_, mesh, step, earlier, environment_.scene_file));
      release(mesh, step);
      begin_interval(mesh, step);
      advance(mesh, velocity, step);
    }
    geodesics_.follow(particles_.particles(), snapshots(), mesh.reference_frame,
                      environment_.context.threads);
    output_clock_.note(step.time, due_times_);
    environment_.statistics.advect_s += timer.seconds();
    const core::Timer output_timer;
    last_ = {step.cycle, step.time};
    write(mesh, step, has_times() ? !due_times_.empty() : due);
    at_times_.reset();
    environment_.statistics.output_s += output_timer.seconds();
  }

  void keep(core::Archive& archive) override {
    archive.value("executed", seeded_);
    archive.value("time of particles", settled_);
    archive.value("last cycle", last_.cycle);
    archive.value("last time", last_.time);
    clock_.keep(archive);
    output_clock_.keep(archive);
    particles_.keep(archive);
    geodesics_.keep(archive);
    for (const auto& writer : writers_)
      writer->keep(archive);
  }
  void take_up_cells() override { same_cells_ = true; }

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
    s.accuracy = accuracy();
    s.time_interpolation = tracer_.time_interpolation;
    s.attached = tracer_.attached == Attached::body;
    s.backward = tracer_.direction == TracerDirection::backward;
    if (tracer_.until.duration)
      s.duration = *tracer_.until.duration;
    if (tracer_.effects.age_limit)
      s.duration = std::min(s.duration, *tracer_.effects.age_limit);
    if (tracer_.until.length)
      s.length = *tracer_.until.length;
    return s;
  }

  /// Whether the mesh's cells are those of the step that the particles are at.
  bool knows_cells(const commit::CommittedMesh& mesh) const {
    return topology_ == mesh.topology_version() || same_cells_;
  }

  bool may_release(const commit::CommittedMesh& mesh, const Step& step) const {
    const Release& release = tracer_.release;
    return !release.when ||
           release.when->evaluate(
               step.cycle, step.time, [&](Reduction reduction, const std::string& field) {
                 return reduce_field(mesh, {field, release.line}, environment_.scene_file,
                                     reduction, environment_.context.threads);
               });
  }

  /// How many steps before this one may serve, if they are kept: if the last is the step that the
  /// particles are at, on the same cells.
  int earlier_steps(const commit::CommittedMesh& mesh, const Step& step) const {
    const bool known = knows_cells(mesh) && !step.first && settled_ == step.earlier_time;
    return known ? advect::steps_of(tracer_.time_interpolation) - 1 : 0;
  }

  /// The step that the particles are at, if its cells are others; or null.
  const commit::EarlierMesh* other_cells(const commit::CommittedMesh& mesh,
                                         const Step& step) const {
    const commit::EarlierMesh* const before = mesh.earlier_mesh();
    const bool known = before && goes_on_to_other_cells() && seeded_ && !step.first &&
                       settled_ == step.earlier_time && topology_ == before->topology_version();
    return known ? before : nullptr;
  }

  /// Between which steps the particles move now.
  void begin_interval(const commit::CommittedMesh& mesh, const Step& step) {
    interval_ = {advect::StepTimes(settled_, step.time, step.times_before),
                 earlier_steps(mesh, step), other_cells(mesh, step)};
    if (!due_times_.empty()) {
      std::vector<double> times;
      for (const DueTime& due : due_times_)
        times.push_back(due.time);
      at_times_.emplace(std::move(times), environment_.context.memory);
    }
  }
  advect::Snapshots* snapshots() { return at_times_ ? &*at_times_ : nullptr; }

  /// Says when the velocity is interpolated through fewer steps than were asked for, and when
  /// through all of them again.
  void note_steps(const Step& step, const advect::Advance& advance) {
    const int asked = advect::steps_of(tracer_.time_interpolation);
    if (asked == 2 || !own_.is_before(settled_, step.time) ||
        advance.velocity_steps == served_steps_)
      return;
    served_steps_ = advance.velocity_steps;
    environment_.context.log.info("cycle " + std::to_string(step.cycle) + ": tracer '" +
                                  tracer_.name + "': the velocity is interpolated through " +
                                  std::to_string(served_steps_) + " of " + std::to_string(asked) +
                                  " steps in time");
  }

  /// Adds the particles that begin between the last step and this one.
  void release(const commit::CommittedMesh& mesh, const Step& step) {
    if (seeded_ && (std::isnan(step.time) || own_.is_before(step.time, settled_)))
      throw core::Error(INSITU_ERROR_ARGUMENT,
                        std::string("time went ") + (own_.backward() ? "on" : "back") + " from " +
                            std::to_string(settled_) + " to " + std::to_string(step.time) +
                            (own_.backward() ? ", and this tracer goes backward" : "") +
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
    geodesics_.begin(particles_.particles(), mesh.reference_frame);
  }

  void advance(commit::CommittedMesh& mesh, const mesh::FieldView& velocity, const Step& step) {
    core::Context& context = environment_.context;
    std::vector<mesh::FieldView> earlier;
    if (earlier_steps(mesh, step) > 0)
      earlier = mesh.mesh().earlier_fields(tracer_.velocity.text);
    if (tracer_.effects.moves() || !mesh.tells_sound_cells())
      mesh.look_for_folds(context.threads); // particles ask with hints
    mesh.find_neighbours_if_due(context.threads);
    const auto hide = [&] { mesh.hide_earlier(); };
    if (earlier.empty())
      hide();
    else
      mesh.show_earlier(context.threads);
    std::optional<advect::StepBefore> before;
    try {
      if (interval_.other_cells)
        before = step_before(tracer_, *interval_.other_cells, mesh.reference_frame);
      if (before && velocity.has_blanks)
        before->sampler =
            cells_.earlier_sampler(before->sampler, before->velocity, context.threads);
      std::vector<mesh::FieldView> velocities{velocity};
      velocities.insert(velocities.end(), earlier.begin(), earlier.end());
      const query::Sampler sampler = cells_.sampler(mesh, velocities, context.threads);
      const auto left_out = [&] { return cells_.left_out(mesh, context.threads); };
      advect::Exits exits(mesh.sampler(), left_out, accuracy());
      particles_.tell_exits_by(&exits);
      const advect::Advance advance =
          particles_.advance(sampler, velocity, {earlier, step.times_before}, settled_, step.time,
                             context.threads, snapshots(), before ? &*before : nullptr);
      note_steps(step, advance);
      mesh_moved_ = mesh_moved_ || advance.blended_geometry;
    } catch (...) {
      particles_.tell_exits_by(nullptr);
      hide();
      throw;
    }
    particles_.tell_exits_by(nullptr);
    hide();
    settled_ = step.time;
    topology_ = mesh.topology_version();
    same_cells_ = false;
  }

  void write(const commit::CommittedMesh& mesh, const Step& step, bool due) {
    ParticleCycle cycle({*this, particles_.particles(), geodesics_, due_times_, snapshots(),
                         interval_, mesh_moved_},
                        mesh, step, due);
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
  TracerCells cells_{environment_.context.memory};
  OwnTime own_;
  ReleaseClock clock_;
  TrackGeodesics geodesics_;
  OutputClock output_clock_;
  // Of one execution.
  std::vector<DueTime> due_times_; ///< of the tracer's own times
  std::optional<advect::Snapshots> at_times_;
  StepInterval interval_;
  std::vector<std::unique_ptr<TrackWriter>> writers_;
  bool seeded_ = false;
  bool mesh_moved_ = false; ///< under the particles, ever
  double settled_ = 0.0;    ///< the time that the particles are at
  int served_steps_ = 0;    ///< through which the velocity was interpolated last
  std::uint64_t topology_ = 0;
  bool same_cells_ = false; ///< as at the checkpoint of a restart
  struct {
    std::int64_t cycle = 0;
    double time = 0.0;
  } last_; ///< the last execution
};

} // namespace

std::unique_ptr<TracerAction> make_tracer_action(const Tracer& tracer,
                                                 const Environment& environment) {
  if (tracer.kind == TracerKind::streamline)
    return make_stream_tracer(tracer, environment);
  return std::make_unique<ParticleTracer>(tracer, environment);
}

} // namespace insitu::scene

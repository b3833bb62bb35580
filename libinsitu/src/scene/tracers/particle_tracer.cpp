#include "scene/tracers/particle_tracer.h"

#include <algorithm>
#include <cmath>

#include "core/status.h"
#include "core/timer.h"
#include "scene/run/lookup.h"
#include "scene/tracers/tracer_effects.h"

namespace insitu::scene {

std::vector<mesh::KeptField> ParticleTracer::needs_earlier() const {
  if (counts().alive() == 0 && !clock_.goes_on(last_.time))
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

void ParticleTracer::execute(commit::CommittedMesh& mesh, const Step& step, bool due) {
  if (across())
    return execute_across(mesh, step, due);
  const core::Timer timer;
  if (goes_on(step)) {
    if (interval_.other_cells)
      interval_.other_cells = mesh.earlier_mesh();
    return write_step(mesh, step, due, timer);
  }
  check_geodesics(mesh);
  bring_home(mesh);
  if (!knows_cells(mesh))
    particles_.particles().leave_cells_of_ended();
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
  moved_ = true;
  write_step(mesh, step, due, timer);
}

/// The particles are where they are to be: writes them, if it is time. timer: since the step began.
void ParticleTracer::write_step(const commit::CommittedMesh& mesh, const Step& step, bool due,
                                const core::Timer& timer) {
  output_clock_.note(step.time, due_times_);
  environment_.statistics.advect_s += timer.seconds();
  const core::Timer output_timer;
  last_ = {step.cycle, step.time};
  const bool writes_now = has_times() ? !due_times_.empty() : due;
  if (across())
    write_across(mesh, step, writes_now);
  else
    write(mesh, step, writes_now);
  at_times_.reset();
  environment_.statistics.output_s += output_timer.seconds();
}

/// What all processes have alike.
void ParticleTracer::keep(core::Archive& archive) {
  advect::Counts all = counts();
  archive.value("particles by ending", all.by_ending);
  archive.value("executed", seeded_);
  archive.value("time of particles", settled_);
  archive.value("last cycle", last_.cycle);
  archive.value("last time", last_.time);
  clock_.keep(archive);
  output_clock_.keep(archive);
  archive.value("mesh moved", mesh_moved_);
  particles_.particles().keep_common(archive);
  if (!archive.restores())
    return;
  all.seeded = all.sum();
  counts_ = all;
  is_restored_ = true;
}

void ParticleTracer::keep_at_root(core::Archive& archive) {
  advect::Particles& particles = kept_ && kept_->all ? *kept_->all : particles_.particles();
  particles.keep(archive);
  archive.array("names of cells", kept_ ? kept_->cells : cell_names_);
  geodesics_.keep(archive);
  for (const auto& writer : writers_)
    writer->keep(archive);
  kept_.reset();
}

void ParticleTracer::meet_checkpoint(const commit::CommittedMesh* mesh) {
  kept_.reset();
  if (is_restored_ || (!across() && (!mesh || !names_cells(*mesh, environment_.world))))
    return; // as they are
  kept_.emplace();
  gather_kept(particles_.particles(), mesh, environment_.world, environment_.context.memory,
              *kept_);
}

void ParticleTracer::bring_home(const commit::CommittedMesh& mesh) {
  if (!is_restored_)
    return;
  deal_kept(particles_.particles(), cell_names_, {mesh, kept_cells_.get(), accuracy()},
            environment_.world);
  is_restored_ = false;
  cell_names_.clear();
  kept_cells_.reset();
}

void ParticleTracer::finish() {
  particles_.finish();
  if (!seeded_ || !environment_.world.is_root())
    return;
  if (all_)
    all_->kill();
  const advect::Particles& particles = all_ ? *all_ : particles_.particles();
  Failures failures;
  for (const auto& writer : writers_)
    failures.catch_of([&] { writer->finish(particles, geodesics_, last_.cycle, last_.time); });
  failures.throw_if_any();
}

advect::TracerSettings ParticleTracer::settings() const {
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

bool ParticleTracer::may_release(const commit::CommittedMesh& mesh, const Step& step) const {
  const Release& release = tracer_.release;
  return !release.when ||
         release.when->evaluate(
             step.cycle, step.time, [&](Reduction reduction, const std::string& field) {
               return environment_.reductions(mesh, {field, release.line}, environment_.scene_file,
                                              reduction);
             });
}

const commit::EarlierMesh* ParticleTracer::other_cells(const commit::CommittedMesh& mesh,
                                                       const Step& step) const {
  const commit::EarlierMesh* const before = mesh.earlier_mesh();
  const bool known = before && goes_on_to_other_cells() && seeded_ && !step.first &&
                     settled_ == step.earlier_time && topology_ == before->topology_version();
  return known ? before : nullptr;
}

void ParticleTracer::begin_interval(const commit::CommittedMesh& mesh, const Step& step) {
  interval_ = {advect::StepTimes(settled_, step.time, step.times_before), earlier_steps(mesh, step),
               other_cells(mesh, step)};
  if (!due_times_.empty()) {
    std::vector<double> times;
    for (const DueTime& due : due_times_)
      times.push_back(due.time);
    at_times_.emplace(std::move(times), environment_.context.memory);
  }
}

void ParticleTracer::note_steps(const Step& step, const advect::Advance& advance) {
  const int asked = advect::steps_of(tracer_.time_interpolation);
  if (asked == 2 || !own_.is_before(settled_, step.time) || advance.velocity_steps == served_steps_)
    return;
  served_steps_ = advance.velocity_steps;
  environment_.context.log.info("cycle " + std::to_string(step.cycle) + ": tracer '" +
                                tracer_.name + "': the velocity is interpolated through " +
                                std::to_string(served_steps_) + " of " + std::to_string(asked) +
                                " steps in time");
}

void ParticleTracer::check_geodesics(const commit::CommittedMesh& mesh) const {
  if (!tracer_.geodesics.empty() && mesh.reference_frame.kind == INSITU_FRAME_CARTESIAN)
    throw core::Error(INSITU_ERROR_SCENE, environment_.scene_file + ":" +
                                              std::to_string(tracer_.line) +
                                              ": geodesics need a mesh with a place on Earth; the "
                                              "frame of this one is cartesian");
}

void ParticleTracer::check_time(const Step& step) const {
  if (seeded_ && (std::isnan(step.time) || own_.is_before(step.time, settled_)))
    throw core::Error(INSITU_ERROR_ARGUMENT,
                      std::string("time went ") + (own_.backward() ? "on" : "back") + " from " +
                          std::to_string(settled_) + " to " + std::to_string(step.time) +
                          (own_.backward() ? ", and this tracer goes backward" : "") +
                          "; the particles wait where they are");
}

void ParticleTracer::release(const commit::CommittedMesh& mesh, const Step& step) {
  check_time(step);
  std::vector<double> times;
  if (!released_)
    times = clock_.due(step.cycle, step.time);
  if (!times.empty() && may_release(mesh, step)) {
    const std::vector<math::Vec3d>& points = seeds(mesh);
    for (const double time : times) {
      particles_.seed(points, time);
      clock_.note(step.time, 1);
    }
  } else {
    clock_.pass(step.time, times.size());
  }
  released_ = true;
  if (!seeded_)
    settled_ = step.time;
  seeded_ = true;
  geodesics_.begin(particles_.particles(), mesh.reference_frame);
}

void ParticleTracer::advance(commit::CommittedMesh& mesh, const mesh::FieldView& velocity,
                             const Step& step) {
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
      before->sampler = cells_.earlier_sampler(before->sampler, before->velocity, context.threads);
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

void ParticleTracer::write(const commit::CommittedMesh& mesh, const Step& step, bool due) {
  ParticleCycle cycle({*this, particles_.particles(), geodesics_, due_times_, snapshots(),
                       interval_, name_cells(mesh.mesh(), environment_.world), environment_.world,
                       mesh_moved_},
                      mesh, step, due);
  written_.write(step, writers_.size(), [&](std::size_t i) { writers_[i]->write(cycle); });
  if (!keeps_ended())
    particles_.drop_ended(); // in the tables, and needed no more
}

bool ParticleTracer::keeps_ended() const {
  return std::ranges::any_of(writers_, [](const auto& writer) { return writer->keeps_ended(); });
}

std::unique_ptr<TracerAction> make_tracer_action(const Tracer& tracer,
                                                 const Environment& environment) {
  if (tracer.kind == TracerKind::streamline)
    return make_stream_tracer(tracer, environment);
  return std::make_unique<ParticleTracer>(tracer, environment);
}

} // namespace insitu::scene

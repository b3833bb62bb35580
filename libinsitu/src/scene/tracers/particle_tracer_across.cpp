// Particles of a mesh that is spread over processes.
#include <algorithm>
#include <cstdint>
#include <limits>
#include <string>

#include "core/status.h"
#include "core/timer.h"
#include "scene/probes/resolve_points.h"
#include "scene/run/lookup.h"
#include "scene/tracers/gathered_cycle.h"
#include "scene/tracers/mesh_homes.h"
#include "scene/tracers/particle_tracer.h"
#include "scene/tracers/tracer_effects.h"

namespace insitu::scene {

namespace {

bool has_cells(const commit::CommittedMesh& mesh) {
  return mesh.mesh().own_view().own_cell_count() > 0;
}

} // namespace

void ParticleTracer::execute_across(commit::CommittedMesh& mesh, const Step& step, bool due) {
  const core::Timer timer;
  parallel::World& world = environment_.world;
  core::Context& context = environment_.context;
  mesh.update_halo(world, context.threads, context.log);
  const bool is_attached = tracer_.attached == Attached::body;
  const std::vector<mesh::FieldView> velocity =
      find_fields(mesh, {&tracer_.velocity, is_attached ? 0U : 1U}, environment_.scene_file, world);
  recorded_ = find_fields(mesh, tracer_.fields, environment_.scene_file, world);
  names_ = name_cells(mesh.mesh(), world);
  if (goes_on(step))
    return write_step(mesh, step, due, timer);
  bring_home(mesh);
  const int earlier = agree_on_steps(mesh, step);
  world.agree_after([&] {
    check_geodesics(mesh);
    check_time(step);
    particles_.drop_gone(); // if the last execution failed
    at_times_.reset();
    due_times_ = output_clock_.due(step.time);
    particles_.set_effects(effects_at(tracer_, mesh, step, earlier, environment_.scene_file));
  });
  const MeshHomes homes(mesh);
  const advect::Across across{world, homes};
  gather_cells_before(mesh, step);
  release_across(mesh, step, across);
  world.agree_after([&] {
    begin_interval(mesh, step);
    interval_.steps_before = earlier;
    interval_.other_cells = cells_before_.get();
  });
  if (is_attached)
    follow_across(mesh, step, across);
  else
    advance_across(mesh, velocity.front(), step, across);
  moved_ = true;
  write_step(mesh, step, due, timer);
}

/// How many steps before this one serve on all processes that have cells. Whether cells of any are
/// others is told to all, as in one process; those of a halo alone tell nothing.
int ParticleTracer::agree_on_steps(const commit::CommittedMesh& mesh, const Step& step) {
  parallel::World& world = environment_.world;
  constexpr std::int64_t most = std::numeric_limits<std::int64_t>::max();
  std::int64_t agreed[] = {most, own_topology_ == mesh.own_topology_version() || same_cells_};
  std::int64_t& steps = agreed[0];
  world.agree_after([&] {
    if (!has_cells(mesh))
      return;
    steps = seeded_ ? earlier_steps(mesh, step) : 0;
    if (tracer_.attached != Attached::body)
      steps = std::min<std::int64_t>(
          steps, std::int64_t(mesh.mesh().earlier_fields(tracer_.velocity.text).size()));
  });
  world.reduce(agreed, parallel::Reduction::least);
  if (!agreed[1])
    particles_.particles().leave_cells_of_ended();
  return steps == most ? 0 : int(steps);
}

/// The step before on other cells, of all processes, if all that had cells then have kept it.
void ParticleTracer::gather_cells_before(const commit::CommittedMesh& mesh, const Step& step) {
  parallel::World& world = environment_.world;
  cells_before_.reset();
  const commit::EarlierMesh* const here = other_cells(mesh, step);
  std::int64_t any[] = {here != nullptr, had_cells_ && !here};
  world.reduce(std::span(any), parallel::Reduction::greatest);
  if (any[0] && !any[1])
    cells_before_ = commit::EarlierMesh::gathered(
        here, mesh.tree(), mesh.stand_in() ? mesh.stand_in()->chart() : nullptr, world,
        environment_.context.memory, environment_.context.threads);
}

void ParticleTracer::release_across(const commit::CommittedMesh& mesh, const Step& step,
                                    const advect::Across& across) {
  parallel::World& world = environment_.world;
  std::vector<double> times;
  world.agree_after([&] {
    if (!released_)
      times = clock_.due(step.cycle, step.time);
  });
  if (!times.empty() && may_release(mesh, step)) {
    const std::vector<math::Vec3d>& points = seeds_of_all(mesh);
    for (const double time : times) {
      const std::int64_t first = particles_.particles().seeded();
      particles_.seed(points, time, mesh.sampler(), across);
      clock_.note(step.time, 1);
      world.agree_after([&] {
        if (world.is_root())
          geodesics_.add(first, points, mesh.reference_frame);
      });
    }
  } else {
    clock_.pass(step.time, times.size());
  }
  released_ = true;
  if (!seeded_)
    settled_ = step.time;
  seeded_ = true;
}

/// What is to be known of the cells before particles move. Where vertices of one process moved,
/// those of all blend between two steps, as in one process.
void ParticleTracer::look_at_cells_across(commit::CommittedMesh& mesh) {
  core::Context& context = environment_.context;
  parallel::World& world = environment_.world;
  std::int64_t any = 0;
  world.agree_after([&] {
    if (has_cells(mesh)) {
      if (tracer_.effects.moves() || !mesh.tells_sound_cells()) // as one process does
        mesh.look_for_folds(context.threads);
      mesh.find_neighbours_if_due(context.threads);
    }
    mesh.hide_earlier();
    any = interval_.steps_before > 0 && mesh.show_earlier(context.threads);
  });
  const bool here = any != 0;
  world.reduce(std::span(&any, 1), parallel::Reduction::greatest);
  if (any)
    world.agree_after([&] {
      if (!here)
        mesh.show_earlier(context.threads, true);
    });
}

void ParticleTracer::advance_across(commit::CommittedMesh& mesh, const mesh::FieldView& velocity,
                                    const Step& step, const advect::Across& across) {
  core::Context& context = environment_.context;
  parallel::World& world = environment_.world;
  std::vector<mesh::FieldView> earlier;
  std::optional<query::Sampler> sampler;
  const auto left_out = [&] { return cells_.left_out(mesh, context.threads); };
  std::optional<advect::Exits> exits;
  std::optional<advect::StepBefore> before;
  const auto end = [&] {
    particles_.tell_exits_by(nullptr);
    mesh.hide_earlier();
  };
  std::int64_t moved = 0;
  try {
    look_at_cells_across(mesh);
    world.agree_after([&] {
      if (interval_.steps_before > 0 && has_cells(mesh))
        earlier = mesh.mesh().earlier_fields(tracer_.velocity.text);
      std::vector<mesh::FieldView> velocities{velocity};
      velocities.insert(velocities.end(), earlier.begin(), earlier.end());
      sampler = cells_.sampler(mesh, velocities, context.threads);
      if (cells_before_)
        before = step_before(tracer_, *cells_before_, mesh.reference_frame);
      if (before && velocity.has_blanks)
        before->sampler =
            cells_.earlier_sampler(before->sampler, before->velocity, context.threads);
      exits.emplace(mesh.sampler(), left_out, accuracy());
      particles_.tell_exits_by(&*exits);
    });
    const advect::Advance advance =
        particles_.advance(across, *sampler, velocity, {earlier, step.times_before}, settled_,
                           step.time, context.threads, snapshots(), before ? &*before : nullptr);
    counts_ = advance.counts;
    moved = advance.blended_geometry;
    if (world.is_root())
      note_steps(step, advance);
  } catch (...) {
    end();
    throw;
  }
  end();
  world.reduce(std::span(&moved, 1), parallel::Reduction::greatest);
  mesh_moved_ = mesh_moved_ || moved;
  settled_ = step.time;
  topology_ = mesh.topology_version();
  own_topology_ = mesh.own_topology_version();
  same_cells_ = false;
  had_cells_ = has_cells(mesh);
}

/// Particles that go with the mesh's material.
void ParticleTracer::follow_across(const commit::CommittedMesh& mesh, const Step& step,
                                   const advect::Across& across) {
  counts_ = particles_.follow(across, mesh.sampler(), !has_cells(mesh) || knows_cells(mesh),
                              settled_, step.time, environment_.context.threads, snapshots());
  settled_ = step.time;
  topology_ = mesh.topology_version();
  own_topology_ = mesh.own_topology_version();
  same_cells_ = false;
  had_cells_ = has_cells(mesh);
}

/// The root's writers get the rows of all processes.
void ParticleTracer::write_across(const commit::CommittedMesh& mesh, const Step& step, bool due) {
  parallel::World& world = environment_.world;
  std::int64_t wanted[2] = {due, 0};
  for (const std::uint8_t ending : particles_.particles().endings)
    wanted[1] |= ending != INSITU_END_ALIVE && ending != advect::Particles::gone;
  world.reduce(std::span(wanted), parallel::Reduction::greatest);
  const bool writes = wanted[0] || wanted[1], follows = !tracer_.geodesics.empty();
  if (writes || follows) {
    ParticleCycle here({*this, particles_.particles(), geodesics_, due_times_, snapshots(),
                        interval_, names_, world, mesh_moved_, &recorded_},
                       mesh, step, wanted[0] != 0);
    GatheredCycle cycle(here, wanted[0] != 0 || follows, {geodesics_, followed_}, world,
                        environment_.context.threads, environment_.context.memory);
    followed_ = true;
    world.agree_after([&] {
      if (world.is_root() && writes)
        written_.write(step, writers_.size(), [&](std::size_t i) { writers_[i]->write(cycle); });
    });
  }
  if (!keeps_ended())
    particles_.drop_ended();
  particles_.drop_gone();
  cells_before_.reset();
}

void ParticleTracer::meet_end() {
  if (!across() || !seeded_)
    return;
  all_.emplace(environment_.context.memory);
  gather_particles(particles_.particles(), environment_.world, *all_);
  counts_.by_ending[INSITU_END_KILLED] += counts_.alive();
  counts_.by_ending[INSITU_END_ALIVE] = 0;
}

} // namespace insitu::scene

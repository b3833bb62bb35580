/// How a runner goes through a step, and through one that comes again.
#include <algorithm>

#include "core/timer.h"
#include "scene/run/lookup.h"
#include "scene/run/runner.h"

namespace insitu::scene {

/// Executes an action, all processes alike, and notes if it was due. Throws parallel::AgreedError.
void Runner::execute(Action& action, const Step& of_all, Attempt::State& state, bool& any_due) {
  Step step = of_all;
  step.again = state == Attempt::State::begun;
  parallel::World& world = environment_.world;
  commit::CommittedMesh* mesh = nullptr;
  world.agree_after(
      [&] { mesh = &find_host_mesh(step.meshes, action.mesh_name(), environment_.scene_file); });
  const bool due = is_due(action, *mesh, step);
  any_due = any_due || due;
  state = Attempt::State::begun;
  if (world.size() > 1)
    action.execute(*mesh, step, due); // which agrees by itself
  else
    world.agree_after([&] { action.execute(*mesh, step, due); });
  if (due && world.is_root())
    log_particles(action, step.cycle);
}

/// Of a step that is held those that serve one; of one that is done again those that failed.
void Runner::execute_actions(const Step& step, Attempt& attempt, std::string& failures) {
  using State = Attempt::State;
  for (std::size_t i = 0; i < actions_.size(); ++i) {
    Action& action = *actions_[i];
    State& state = attempt.actions[i];
    if (state == State::done)
      continue;
    if (&attempt == &held_ && !action.serves_held_steps()) {
      leave_out(action);
      continue;
    }
    try {
      execute(action, step, state, attempt.any_due);
      state = State::done;
    } catch (const core::Error& e) {
      if (!is_for_want_of_cells(action, e, step.meshes))
        failed(failures, std::string(action.kind()) + " '" + action.name() + "'", e, step.cycle);
    }
  }
}

/// Copies what pathlines will need of this step, and only then.
void Runner::keep_earlier(MeshList meshes) {
  const core::Timer timer;
  for (commit::CommittedMesh* mesh : meshes) {
    std::vector<mesh::KeptField> fields;
    bool with_cells = false;
    for (const auto& action : actions_) {
      if (mesh->lies_on_device())
        continue;
      const bool here = action->is_of(*mesh, meshes);
      for (const mesh::KeptField& need : action->needs_earlier()) {
        if (!here || !mesh->mesh().has_field(need.name))
          continue;
        const auto known = std::find_if(fields.begin(), fields.end(),
                                        [&](const auto& f) { return f.name == need.name; });
        if (known == fields.end())
          fields.push_back(need);
        else
          known->steps = std::max(known->steps, need.steps);
        with_cells = with_cells || action->goes_on_to_other_cells();
      }
    }
    mesh->keep_earlier(fields, with_cells, environment_.context.threads);
  }
  environment_.statistics.advect_s += timer.seconds();
}

/// Keeps what the next step needs of this one, and if a tracer that failed may be executed again,
/// what this step needs of those before.
void Runner::keep_step(const Step& step, std::string& failures) {
  bool is_wanted = false;
  for (std::size_t i = 0; i < actions_.size(); ++i)
    is_wanted |= live_.actions[i] != Attempt::State::done && !actions_[i]->needs_earlier().empty();
  try {
    environment_.world.agree_after([&] {
      for (commit::CommittedMesh* mesh : step.meshes)
        if (is_wanted)
          mesh->set_earlier_aside();
      keep_earlier(step.meshes);
    });
    live_.is_kept = !is_wanted;
  } catch (const core::Error& e) { // no memory: pathlines take the next velocity as steady
    for (commit::CommittedMesh* mesh : step.meshes) {
      mesh->release_earlier();
      mesh->release_aside();
    }
    failed(failures, "the earlier step", e, step.cycle);
  }
}

/// All of a step but for what is written of it as a whole.
void Runner::execute_all(const Step& step, Attempt& attempt, std::string& failures) {
  execute_actions(step, attempt, failures);
  structures_.end_cycle(step.meshes);
  if (&attempt == &live_ && !live_.is_kept)
    keep_step(step, failures);
  try {
    end_page_cycle(step, attempt);
  } catch (const core::Error& e) {
    failed(failures, "page", e, step.cycle);
  }
}

/// Begins a step, or goes on with it where it comes again.
void Runner::begin(Attempt& attempt, std::int64_t cycle, double time) {
  const bool is_again = attempt.is_again(cycle, time);
  if (!is_again) {
    note_cycle(cycle);
    attempt = Attempt();
    attempt.cycle = cycle;
    attempt.time = time;
    attempt.is_first = !executed_;
    attempt.actions.assign(actions_.size(), Attempt::State::none);
    attempt.times = times_;
  }
  const bool goes_on = is_again && last_ == &attempt;
  last_ = &attempt;
  table_.begin_step(goes_on);
  if (page_)
    page_->begin_step(goes_on && attempt.has_entry);
  if (goes_on && attempt.has_entry) // that will tell of all executions of the step
    seconds_.go_back();
  attempt.has_entry = false;
  attempt.is_failed = false;
}

std::string Runner::execute_held(MeshList meshes, std::int64_t cycle, double time) {
  begin(held_, cycle, time);
  for (commit::CommittedMesh* mesh : meshes)
    if (mesh->needs_halo(environment_.world))
      mesh->update_halo(environment_.world, environment_.context.threads, environment_.context.log);
  std::string failures;
  execute_all({meshes, cycle, time, false, time}, held_, failures);
  held_.is_failed = !failures.empty();
  return failures;
}

std::string Runner::execute(MeshList meshes, std::int64_t cycle, double time) {
  const bool is_again = live_.is_again(cycle, time);
  begin(live_, cycle, time);
  const std::span<const double> times(live_.times);
  const Step step{meshes,
                  cycle,
                  time,
                  live_.is_first,
                  times.empty() ? 0.0 : times.front(),
                  times.empty() ? times : times.subspan(1)};
  std::string failures;
  parallel::World& world = environment_.world;
  for (commit::CommittedMesh* mesh : meshes)
    for (const auto& action : actions_)
      if (action->is_of(*mesh, meshes)) // before any action asks for a halo
        mesh->join_sides(action->periodic_axes());
  for (commit::CommittedMesh* mesh : meshes)
    if (mesh->needs_halo(world)) // what an action has asked for, all see: none of an earlier step
      mesh->update_halo(world, environment_.context.threads, environment_.context.log);
  for (commit::CommittedMesh* mesh : meshes) {
    if (is_again && !live_.is_kept)
      mesh->put_earlier_back();
    mesh->release_aside();
  }
  take_up_meshes(meshes);
  execute_all(step, live_, failures);
  if (!is_again) {
    descends_ = executed_ && cycle < cycle_;
    executed_ = true;
    cycle_ = cycle;
    times_.insert(times_.begin(), time);
    times_.resize(std::min(times_.size(), std::size_t(advect::most_steps - 1)));
  }
  write_step_files(meshes, failures);
  live_.is_failed = !failures.empty();
  return failures;
}

/// The checkpoint and the record that are due.
void Runner::write_step_files(MeshList meshes, std::string& failures) {
  const core::Timer timer;
  try {
    write_due_checkpoint(meshes);
  } catch (const core::Error& e) {
    failed(failures, "checkpoint", e, cycle_);
  }
  try {
    if (record_.every && cycle_ % *record_.every == 0)
      write_record(record_path(environment_.output, cycle_), meshes, cycle_, live_.time);
  } catch (const core::Error& e) {
    failed(failures, "record", e, cycle_);
  }
  environment_.statistics.output_s += timer.seconds();
}

} // namespace insitu::scene

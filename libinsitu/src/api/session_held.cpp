/// Steps held beside the live one.
#include "api/session.h"
#include "core/timer.h"

namespace insitu::api {

using core::Error;

void Session::hold(int steps) {
  meet("hold");
  processes_.world().require_same([&] {
    return std::vector<parallel::Named>{{"steps to hold", std::to_string(steps)}};
  });
  processes_.world().agree_after([&] {
    if (steps < 0)
      throw Error(INSITU_ERROR_ARGUMENT,
                  "steps: " + std::to_string(steps) + ", 0 (none) or more expected");
    if (shown_)
      throw Error(INSITU_ERROR_ORDER, "hold: cycle " + std::to_string(shown_->cycle) +
                                          " is shown; show the live step first");
  });
  held_.set_most(steps);
  if (steps == 0 && runner_)
    runner_->keep_structures_of({});
}

void Session::show(std::int64_t cycle) {
  meet("show");
  parallel::World& world = processes_.world();
  world.require_same([&] {
    return std::vector<parallel::Named>{
        {"cycle to show", cycle == INSITU_LIVE ? "the live one" : std::to_string(cycle)}};
  });
  const commit::HeldStep* step = nullptr;
  world.agree_after([&] {
    if (cycle != INSITU_LIVE)
      step = &held_.find(cycle);
  });
  shown_ = nullptr; // should the next fail
  world.agree_after([&] {
    if (step)
      held_.put(*step, context_.threads);
  });
  shown_ = step;
  if (runner_)
    runner_->show_other();
}

commit::CommittedMesh& Session::answering(SessionMesh& mesh) {
  if (!shown_)
    return mesh.mesh;
  const std::string& name = mesh.mesh.mesh().name();
  for (const commit::HeldStep::OfMesh& m : shown_->meshes)
    if (m.mesh->mesh().mesh().name() == name)
      return m.mesh->mesh();
  throw Error(INSITU_ERROR_ORDER, "mesh '" + name + "' was not there in cycle " +
                                      std::to_string(shown_->cycle) + ", which is shown");
}

/// Frames keep what they have made of steps that may be shown, and of the live one.
void Session::keep_structures() {
  if (!runner_)
    return;
  std::vector<std::uint64_t> ids;
  for (const commit::CommittedMesh* const m : held_.meshes())
    ids.push_back(m->id());
  for (const auto& m : meshes_)
    ids.push_back(m->mesh.id());
  runner_->keep_structures_of(std::move(ids));
}

/// Returns what failed.
std::string Session::execute_shown(std::int64_t cycle, double time) {
  std::vector<commit::CommittedMesh*> meshes;
  processes_.world().agree_after([&] {
    meshes = shown_->shown();
    keep_structures();
  });
  ++statistics_.executions;
  return runner_ ? runner_->execute_held(meshes, cycle, time) : std::string();
}

/// Returns what failed.
std::string Session::hold_step(const std::vector<commit::CommittedMesh*>& meshes) {
  if (held_.most() == 0)
    return {};
  const core::Timer timer;
  std::string failure;
  try {
    held_.hold(cycle_, time_, meshes, processes_.world(), context_.threads);
  } catch (const Error& e) {
    ++statistics_.failures;
    failure = "cycle " + std::to_string(cycle_) + " is not held: " + e.what();
    if (hold_failure_ != e.what() && processes_.world().is_root())
      context_.log.error(failure);
    hold_failure_ = e.what();
  }
  statistics_.commit_s += timer.seconds();
  return failure;
}

} // namespace insitu::api

#include "api/output_locks.h"

namespace insitu::api {

namespace {

/// That no table has, so that the lock of an action is never that of a file.
const std::string action_ending = ".action";

std::unique_ptr<output::FileLock> lock_action(const std::string& target) {
  const std::string files = target.substr(0, target.size() - action_ending.size()) + "*";
  return std::make_unique<output::FileLock>(target, files);
}

} // namespace

void OutputLocks::take(const scene::SceneDescription& scene, const std::string& folder) {
  Locks taken;
  const auto add = [&](const std::string& name) {
    const std::string target = folder + "/" + name + action_ending;
    taken[target] = lock_action(target);
  };
  for (const scene::Probe& p : scene.probes)
    add(p.name);
  for (const scene::Tracer& t : scene.tracers)
    add(t.name);
  for (const scene::Frame& f : scene.frames)
    add(f.name);
  if (scene.checkpoint.every)
    add("checkpoint");
  if (scene.record.every)
    add("record.hdf");
  actions_ = std::move(taken);
}

void OutputLocks::take_missing() {
  for (auto& [target, lock] : actions_)
    if (!lock->held())
      lock = lock_action(target);
}

void OutputLocks::take(const std::string& path) {
  if (const auto known = files_.find(path); known != files_.end() && known->second->held())
    return;
  files_[path] = std::make_unique<output::FileLock>(path);
}

void OutputLocks::release() {
  actions_.clear();
  files_.clear();
}

} // namespace insitu::api

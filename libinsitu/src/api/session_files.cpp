/// The files that a session's caller asks for: checkpoints and records, and taking a checkpoint up.
#include "api/session.h"

namespace insitu::api {

using core::Error;

void Session::checkpoint(const std::string& path) {
  meet("checkpoint");
  processes_.world().require_same([&] {
    return std::vector<parallel::Named>{{"checkpoint", "'" + path + "'"}};
  });
  std::vector<commit::CommittedMesh*> meshes;
  processes_.world().agree_after([&] {
    if (!runner_)
      throw Error(INSITU_ERROR_ORDER, "checkpoint '" + path + "': nothing was executed yet");
    meshes = executed_meshes("checkpoint '" + path + "'");
    if (processes_.world().is_root())
      locks_.take(path);
  });
  runner_->write_checkpoint(path, meshes);
}

std::vector<commit::CommittedMesh*> Session::executed_meshes(const std::string& what) {
  if (statistics_.executions == 0)
    throw Error(INSITU_ERROR_ORDER, what + ": nothing was executed yet");
  std::vector<commit::CommittedMesh*> meshes;
  for (const auto& m : meshes_) {
    if (!m->mesh.committed())
      throw Error(INSITU_ERROR_ORDER, what + ": mesh '" + m->mesh.mesh().name() +
                                          "' was changed since the last execute, of whose step the "
                                          "file is to be");
    meshes.push_back(&m->mesh);
  }
  return meshes;
}

void Session::record(const std::string& path) {
  meet("record");
  processes_.world().require_same([&] {
    return std::vector<parallel::Named>{{"record", "'" + path + "'"}};
  });
  std::vector<commit::CommittedMesh*> meshes;
  processes_.world().agree_after([&] {
    meshes = shown_ ? shown_->shown() : executed_meshes("record '" + path + "'");
    if (processes_.world().is_root())
      locks_.take(path);
  });
  const std::int64_t cycle = shown_ ? shown_->cycle : cycle_;
  const double time = shown_ ? shown_->time : time_;
  if (runner_)
    runner_->write_record(path, meshes, cycle, time);
  else {
    if (!records_)
      records_.emplace(context_, processes_.world(), statistics_);
    records_->write(path, {cycle, time, {}, {}}, meshes);
  }
}

void Session::restart(const std::string& path) {
  meet("restart");
  processes_.world().require_same([&] {
    return std::vector<parallel::Named>{{"restart from", "'" + path + "'"}};
  });
  std::unique_ptr<scene::Runner> fresh;
  processes_.world().agree_after([&] {
    if (!scene_)
      throw Error(INSITU_ERROR_ORDER, "restart from '" + path + "': the session has no scene");
    if (statistics_.executions > 0)
      throw Error(INSITU_ERROR_ORDER, "restart from '" + path + "': this session has executed " +
                                          std::to_string(statistics_.executions) +
                                          " times; restart before the first execute");
    // A runner of its own: should it fail, the one that is there goes on as if nothing had been
    // asked.
    fresh = std::make_unique<scene::Runner>(*scene_, output_, context_, processes_.world(),
                                            statistics_);
  });
  fresh->restart(path);
  runner_ = std::move(fresh);
}

} // namespace insitu::api

#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "commit/committed_mesh.h"
#include "core/log.h"
#include "parallel/world.h"

namespace insitu::api {

/// The processes of the communicator that the options give, or this one alone. Collective; throws
/// core::Error.
std::shared_ptr<parallel::World> world_of(const insitu_session_options& options,
                                          const core::Log& log);

/// The processes of a session, and what they have to agree on before one of them works. The calls
/// that open, execute and close a session are collective; see parallel/world.h.
class Processes {
public:
  explicit Processes(std::shared_ptr<parallel::World> world) : world_(std::move(world)) {}

  parallel::World& world() { return *world_; }
  const parallel::World& world() const { return *world_; }
  int size() const { return world_->size(); }

  /// How many threads a session of these options may have here: the cores that the node's processes
  /// may use, divided by their number, unless the options say it. Throws core::Error for options
  /// with which no session is made.
  int threads(const insitu_session_options& options) const;

  /// In a checked session, waits for all processes, for as many seconds as the environment's
  /// INSITU_WAIT says (60 without it). Throws core::Error (INSITU_ERROR_ORDER) that names one that
  /// does not come; the session is then of no use but to be closed.
  void wait_for_all(const std::string& call);
  /// All have opened a session of the same options and scene, checked or not. Throws
  /// parallel::AgreedError.
  void agree_on_session(const insitu_session_options& options, bool checked);
  /// All are at the same cycle of the same time. Throws parallel::AgreedError.
  void agree_on_time(std::int64_t cycle, double time);
  /// Meshes of one name have fields alike, and lie in the same frame of reference: those without
  /// cells take that of the others. Returns the names of the meshes of all processes, in one order
  /// for all; meshes that a process lacks are made by make(name), and empty. Of one process: of its
  /// meshes. Throws parallel::AgreedError.
  using Make = core::FunctionRef<commit::CommittedMesh&(const std::string& name)>;
  std::vector<std::string> agree_on_meshes(std::span<commit::CommittedMesh* const> meshes,
                                           Make make);
  /// The first scalar field of the first mesh that has one, and that mesh, as of the last
  /// agree_on_meshes(); empty names if there is none.
  std::pair<std::string, std::string>
  scalar_of_all(std::span<commit::CommittedMesh* const> meshes) const;

private:
  void agree_on_frames(std::span<commit::CommittedMesh* const> meshes);

  std::shared_ptr<parallel::World> world_;
  std::string last_list_;          ///< of meshes and their frames, that were compared
  std::vector<std::string> names_; ///< of the meshes then
  std::pair<std::string, std::string> scalar_;
};

} // namespace insitu::api

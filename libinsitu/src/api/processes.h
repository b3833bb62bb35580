#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "commit/committed_mesh.h"
#include "core/log.h"
#include "parallel/world.h"

namespace insitu::api {

/// The processes of a session, and what they have to agree on before one of them works. The calls
/// that open, execute and close a session are collective; see parallel/world.h.
class Processes {
public:
  /// Those of the communicator that the options give, or this one alone. Throws core::Error.
  Processes(const insitu_session_options& options, const core::Log& log);

  parallel::World& world() { return *world_; }
  int size() const { return world_->size(); }

  /// How many threads a session of these options may have here: the node's cores divided by its
  /// processes, unless the options say it.
  int threads(const insitu_session_options& options) const;

  /// In a checked session, waits for all processes, for as many seconds as the environment's
  /// INSITU_WAIT says (60 without it). Throws core::Error (INSITU_ERROR_ORDER) that names one that
  /// does not come; the session is then of no use but to be closed.
  void wait_for_all(const std::string& call);
  /// All have opened a session of the same options and scene, checked or not. Throws
  /// parallel::AgreedError.
  void agree_on_session(const insitu_session_options& options, bool checked);
  /// All execute the same cycle of the same time, and meshes of one name have fields alike.
  /// Returns the names of the meshes that this process lacks and others have, which it takes as
  /// empty. Throws parallel::AgreedError.
  std::vector<std::string> agree_on_step(std::int64_t cycle, double time,
                                         std::span<commit::CommittedMesh* const> meshes);

private:
  std::unique_ptr<parallel::World> world_;
  std::string last_fields_; ///< that were compared
};

} // namespace insitu::api

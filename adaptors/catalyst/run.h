#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "insitu/insitu.hpp"

#include "blueprint/attachment.h"
#include "blueprint/node.h"

namespace insitu::catalyst {

/// An error of a call that the library has logged already.
struct Logged : Error {
  explicit Logged(const Error& e) : Error(e) {}
};

/// A session that a solver runs through Catalyst's calls: from initialize to finalize.
class Run {
public:
  /// Opens the session that `catalyst` in a call's parameters asks for. scene: the path of one that
  /// replaces what the parameters and the environment name, or "". Throws Error.
  explicit Run(const blueprint::Node& catalyst, const std::string& scene = "");

  /// Gives the channels' meshes to the session, and executes it. A channel of a kind that the
  /// library cannot read is left out, and said once. Returns false if an action failed (the library
  /// has logged it); throws Error for any other failure, such as a channel that is wrong on this
  /// process or another one: nothing is executed then.
  bool execute(const blueprint::Node& catalyst);

  /// What execute() does before the session executes, for a dry run. Throws Error.
  void give(const blueprint::Node& catalyst);
  Session& session() { return *session_; }
  /// The meshes of the call before, by the channels' names.
  std::vector<std::pair<std::string, Mesh>> meshes();

  /// What the session did so far, and what its probes answered last, as catalyst/insitu/... of the
  /// node. Any process may ask, at any time.
  void write_results(const blueprint::Conduit& conduit, void* node) const;

  void close() { session_->close(); }

private:
  struct Channel {
    explicit Channel(insitu_mesh mesh) : attachment(mesh) {}
    blueprint::Attachment attachment;
    bool adaptive = false;
    bool present = false; ///< in this call
  };
  /// A channel's data, or a block of it.
  void attach(const std::string& mesh, const blueprint::Node& data,
              const blueprint::Attachment::Options& options);
  /// A channel's data, or a block of it, with a mesh for each further topology.
  void attach_all(const std::string& mesh, const blueprint::Node& data,
                  const blueprint::Node& channel);
  void attach_channel(const blueprint::Node& channel);
  /// Returns the error of a channel that is wrong.
  std::optional<Error> give_channels(const blueprint::Node& catalyst);
  void take_clock(const blueprint::Node& catalyst);
  void say_once(const std::string& text);

  std::map<std::string, std::unique_ptr<Channel>> channels_; ///< outlives the session
  std::optional<Session> session_;
  std::set<std::string> said_;
  std::int64_t cycle_ = -1;
  double time_ = 0;
};

/// The scene of a run: the environment's INSITU_SCENE, or the script among catalyst/scripts whose
/// name ends in .yaml or .yml; "" without one. Throws Error if there are several.
std::string scene_of(const blueprint::Node& catalyst);

/// Tells the solver's user, on stderr.
void say(const char* prefix, const std::string& text);

} // namespace insitu::catalyst

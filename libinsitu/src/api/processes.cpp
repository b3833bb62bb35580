#include "api/processes.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <iterator>
#include <map>

#include "api/array_watch.h"
#include "api/meshes_of_all.h"
#include "core/simd_target.h"
#include "core/text.h"
#include "parallel/mpi_world.h"

namespace insitu::api {

using core::Error;

namespace {

/// A scene's length and a checksum of it.
std::string told(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text)
    hash = (hash ^ std::uint8_t(c)) * 0x100000001b3u;
  char sum[16];
  const std::string checksum(sum, std::to_chars(sum, sum + sizeof sum, hash, 16).ptr);
  return "of " + std::to_string(text.size()) + " bytes (checksum " + checksum + ")";
}

/// The shortest text that is this number again.
std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// A frame of reference as text, for messages.
std::string told(const insitu_frame& f) {
  constexpr const char* kinds[] = {"cartesian", "geocentric", "geodetic", "east_north_up", "utm"};
  std::string text = std::size_t(f.kind) < std::size(kinds) ? kinds[f.kind] : "unknown";
  for (const double x : f.origin)
    text += " " + shortest(x);
  for (const int x : {f.utm_zone, f.utm_north, int(f.angle), int(f.length), int(f.vertical)})
    text += " " + std::to_string(x);
  return text;
}

/// Throws for options with which no session is made.
void check(const insitu_session_options& options) {
  core::require_simd_target();
  if (options.threads == INSITU_LACKS_MEMORY)
    throw Error(INSITU_ERROR_MEMORY, "out of memory");
  if (options.threads < 0)
    throw Error(INSITU_ERROR_ARGUMENT,
                "threads: " + std::to_string(options.threads) + ", 0 (all) or more expected");
  if (options.scene && options.scene_text)
    throw Error(INSITU_ERROR_ARGUMENT, "scene and scene_text are both given, at most one expected");
}

bool has_cells(const commit::CommittedMesh& mesh) {
  return mesh.mesh().own_view().own_cell_count() > 0;
}

/// INSITU_WAIT, in which all processes come to a call of a checked session.
double seconds_to_wait() {
  const char* const given = std::getenv("INSITU_WAIT");
  const double asked = given ? std::atof(given) : 0;
  return asked > 0 ? asked : 60;
}

} // namespace

std::shared_ptr<parallel::World> world_of(const insitu_session_options& o, const core::Log& log) {
  const bool given = o.communicator || o.fortran_communicator != INSITU_NO_COMMUNICATOR;
  if (!given)
    return std::make_shared<parallel::SerialWorld>();
  if (!parallel::has_mpi()) {
    log.warning("communicator: this build has no MPI and does not use it. Each process works on "
                "its own pieces alone; give each process an output folder of its own, since a "
                "second session that writes the same files is refused");
    return std::make_shared<parallel::SerialWorld>();
  }
  return parallel::make_mpi_world(o.communicator, o.fortran_communicator, log,
                                  is_checked() ? seconds_to_wait() : 0.0);
}

int Processes::threads(const insitu_session_options& options) const {
  check(options);
  if (options.threads > 0 || size() == 1)
    return options.threads;
  return std::max(1, world_->cores_here() / world_->on_this_node());
}

void Processes::wait_for_all(const std::string& call) {
  const double seconds = seconds_to_wait();
  const int missing = world_->wait_for_all(seconds);
  if (missing >= 0)
    throw Error(INSITU_ERROR_ORDER, call + ": process " + std::to_string(missing) + " of " +
                                        std::to_string(size()) + " did not call it within " +
                                        shortest(seconds) +
                                        " s (INSITU_WAIT); the session can only be closed");
}

void Processes::agree_on_session(const insitu_session_options& o, bool checked) {
  if (size() == 1)
    return;
  world_->require_same([&] {
    std::string scene = "none";
    if (o.scene)
      scene = "file '" + std::string(o.scene) + "'"; // the root reads it
    else if (o.scene_text)
      scene = told(std::string(o.scene_text));
    return std::vector<parallel::Named>{{"scene", scene},
                                        {"default_scene", std::to_string(o.default_scene != 0)},
                                        {"strict", std::to_string(o.strict != 0)},
                                        {"preview", std::to_string(o.preview != 0)},
                                        {"checked", std::to_string(checked)}};
  });
}

void Processes::agree_on_time(std::int64_t cycle, double time) {
  if (size() > 1)
    world_->require_same([&] {
      return std::vector<parallel::Named>{{"cycle", std::to_string(cycle)},
                                          {"time", shortest(time)}};
    });
}

std::vector<std::string> Processes::agree_on_meshes(std::span<commit::CommittedMesh* const> meshes,
                                                    Make make) {
  if (size() == 1) {
    names_.clear();
    for (const commit::CommittedMesh* const m : meshes)
      names_.push_back(m->mesh().name());
    return names_;
  }
  std::string mine, list;
  world_->agree_after([&] {
    mine = list_meshes(meshes);
    list = mine;
    for (const commit::CommittedMesh* const m : meshes)
      list += (has_cells(*m) ? "cells in " : "no cells in ") + told(m->reference_frame) + "\n";
  });
  std::int64_t changed = names_.empty() || list != last_list_;
  world_->reduce(std::span(&changed, 1), parallel::Reduction::greatest);
  if (!changed)
    return names_;
  last_list_.clear(); // compared again, should this fail
  std::map<int, std::string> lists;
  world_->gather(std::as_bytes(std::span(mine.data(), mine.size())), std::size_t(1) << 20,
                 [&](int rank, std::span<const std::byte> bytes) {
                   lists[rank].append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                 });
  std::string names;
  std::pair<std::string, std::string> scalar;
  world_->agree_after([&] {
    MeshesOfAll all;
    for (const auto& [rank, of] : lists)
      all.add(rank, of);
    names = all.names();
    scalar = all.scalar();
  });
  names = world_->broadcast(names);
  scalar_.first = world_->broadcast(scalar.first);
  scalar_.second = world_->broadcast(scalar.second);
  std::vector<commit::CommittedMesh*> all_meshes;
  world_->agree_after([&] {
    names_ = core::parted(names);
    for (const std::string& name : names_)
      all_meshes.push_back(&make(name));
  });
  agree_on_frames(all_meshes);
  last_list_ = std::move(list);
  return names_;
}

std::pair<std::string, std::string>
Processes::scalar_of_all(std::span<commit::CommittedMesh* const> meshes) const {
  if (size() > 1)
    return scalar_;
  MeshesOfAll mine;
  mine.add(0, list_meshes(meshes));
  return mine.scalar();
}

/// The frame of each mesh is that of the first process that has cells of it.
void Processes::agree_on_frames(std::span<commit::CommittedMesh* const> meshes) {
  for (commit::CommittedMesh* const mesh : meshes) {
    const bool has = has_cells(*mesh);
    std::int64_t first = has ? world_->rank() : size();
    world_->reduce(std::span(&first, 1), parallel::Reduction::least);
    if (first == size())
      continue;
    insitu_frame frame = mesh->reference_frame;
    world_->broadcast(std::as_writable_bytes(std::span(&frame, 1)), int(first));
    world_->agree_after([&] {
      if (told(mesh->reference_frame) == told(frame))
        return;
      if (has)
        throw Error(INSITU_ERROR_ARGUMENT, "processes differ: the frame of mesh '" +
                                               mesh->mesh().name() + "' is " + told(frame) +
                                               " on process " + std::to_string(first) + ", " +
                                               told(mesh->reference_frame) + " here");
      mesh->reference_frame = frame;
      mesh->mesh().set_changed(INSITU_CHANGED_TOPOLOGY);
    });
  }
}

} // namespace insitu::api

#include "api/processes.h"

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <sstream>
#include <unistd.h>

#include "core/simd_target.h"
#include "parallel/mpi_world.h"

namespace insitu::api {

using core::Error;

namespace {

std::unique_ptr<parallel::World> world_of(const insitu_session_options& o, const core::Log& log) {
  const bool given = o.communicator || o.fortran_communicator != INSITU_NO_COMMUNICATOR;
  if (!given)
    return std::make_unique<parallel::SerialWorld>();
  if (!parallel::has_mpi()) {
    log.warning("communicator: this build has no MPI and does not use it. Each process works on "
                "its own pieces alone; give each process an output folder of its own, since a "
                "second session that writes the same files is refused");
    return std::make_unique<parallel::SerialWorld>();
  }
  auto world = parallel::make_mpi_world(o.communicator, o.fortran_communicator, log);
  if (world->size() > 1 && world->is_root())
    log.warning("communicator: the processes agree on scenes, cycles, fields and errors, and this "
                "version does no more: each process works on its own pieces alone. Probes and "
                "tracers end where these do, images show these, and totals are of one process. "
                "Give each process an output folder of its own, since a second session that writes "
                "the same files is refused");
  return world;
}

/// A scene's length and a checksum of it.
std::string told(const std::string& text) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char c : text)
    hash = (hash ^ std::uint8_t(c)) * 0x100000001b3u;
  std::ostringstream out;
  out << "of " << text.size() << " bytes (checksum " << std::hex << hash << ")";
  return out.str();
}

/// The shortest text that is this number again.
std::string shortest(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

/// Adds a pair of texts to a list of pairs. Names hold any byte but 0.
void add_pair(std::string& list, const std::string& first, const std::string& second) {
  list.append(first).push_back('\0');
  list.append(second).push_back('\0');
}

/// Takes the pairs of a list in their order.
void for_each_pair(const std::string& list,
                   core::FunctionRef<void(const std::string&, const std::string&)> take) {
  std::istringstream in(list);
  for (std::string first, second; std::getline(in, first, '\0') && std::getline(in, second, '\0');)
    take(first, second);
}

/// The name of each mesh with nothing, and "field 'f' of mesh 'm'" with "1 component at vertices".
std::string fields_of(std::span<commit::CommittedMesh* const> meshes) {
  std::string all;
  for (const commit::CommittedMesh* const m : meshes) {
    add_pair(all, m->mesh().name(), "");
    for (const std::string& name : m->mesh().field_names()) {
      const mesh::FieldView field = m->mesh().field(name);
      add_pair(all, "field '" + name + "' of mesh '" + m->mesh().name() + "'",
               std::to_string(field.components) +
                   (field.components == 1 ? " component at " : " components at ") +
                   (field.association == INSITU_VERTEX ? "vertices" : "cells"));
    }
  }
  return all;
}

/// Of the fields of all processes, at the root.
class FieldsOfAll {
public:
  void add(int rank, const std::string& list) {
    for_each_pair(list, [&](const std::string& name, const std::string& what) {
      if (what.empty()) {
        meshes_.insert(name);
        return;
      }
      const auto [known, is_new] = first_.try_emplace(name, rank, what);
      if (!is_new && known->second.second != what)
        throw Error(INSITU_ERROR_FIELD, "processes differ: " + name + " has " +
                                            known->second.second + " on process " +
                                            std::to_string(known->second.first) + ", " + what +
                                            " on process " + std::to_string(rank));
    });
  }
  std::string meshes() const {
    std::string all;
    for (const std::string& name : meshes_)
      add_pair(all, name, "");
    return all;
  }

private:
  std::map<std::string, std::pair<int, std::string>> first_; ///< who has it first, and how
  std::set<std::string> meshes_;
};

} // namespace

Processes::Processes(const insitu_session_options& options, const core::Log& log)
    : world_(world_of(options, log)) {
  // What follows in a session throws for these; nobody waits for a process that does.
  world_->agree_after([&] {
    core::require_simd_target();
    if (options.threads < 0)
      throw Error(INSITU_ERROR_ARGUMENT,
                  "threads: " + std::to_string(options.threads) + ", 0 (all) or more expected");
  });
}

int Processes::threads(const insitu_session_options& options) const {
  if (options.threads > 0 || size() == 1)
    return options.threads;
  const long cores = sysconf(_SC_NPROCESSORS_ONLN);
  return int(std::max(1L, cores / world_->on_this_node()));
}

void Processes::wait_for_all(const std::string& call) {
  const char* const given = std::getenv("INSITU_WAIT");
  const double asked = given ? std::atof(given) : 0;
  const double seconds = asked > 0 ? asked : 60;
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
  std::string scene = "none";
  world_->agree_after([&] {
    if (o.scene) { // it was read already
      std::ifstream in(o.scene, std::ios::binary);
      scene = told({std::istreambuf_iterator<char>(in), {}});
    } else if (o.scene_text) {
      scene = told(o.scene_text);
    }
  });
  world_->require_same({{"scene", scene},
                        {"default_scene", std::to_string(o.default_scene != 0)},
                        {"strict", std::to_string(o.strict != 0)},
                        {"preview", std::to_string(o.preview != 0)},
                        {"checked", std::to_string(checked)}});
}

std::vector<std::string> Processes::agree_on_step(std::int64_t cycle, double time,
                                                  std::span<commit::CommittedMesh* const> meshes) {
  if (size() == 1)
    return {};
  world_->require_same({{"cycle", std::to_string(cycle)}, {"time", shortest(time)}});
  std::string fields;
  world_->agree_after([&] { fields = fields_of(meshes); });
  std::int64_t changed = fields != last_fields_;
  world_->reduce(std::span(&changed, 1), parallel::Reduction::greatest);
  if (!changed)
    return {};
  FieldsOfAll all;
  std::map<int, std::string> lists;
  world_->gather(std::as_bytes(std::span(fields.data(), fields.size())), std::size_t(1) << 20,
                 [&](int rank, std::span<const std::byte> bytes) {
                   lists[rank].append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
                 });
  world_->agree_after([&] {
    for (const auto& [rank, list] : lists)
      all.add(rank, list);
  });
  last_fields_ = std::move(fields);
  std::vector<std::string> absent;
  for_each_pair(world_->broadcast(all.meshes()), [&](const std::string& name, const std::string&) {
    if (std::none_of(meshes.begin(), meshes.end(),
                     [&](const auto* m) { return m->mesh().name() == name; }))
      absent.push_back(name);
  });
  return absent;
}

} // namespace insitu::api

#pragma once

#include <cstdint>
#include <map>
#include <memory>

#include "query/committed_mesh.h"
#include "render/structures.h"

namespace insitu::scene {

/// The structures that the frames of a session share, by mesh.
class FrameStructures {
public:
  FrameStructures(core::Memory& memory, const core::Threads& threads)
      : memory_(&memory), threads_(&threads) {}

  /// Those of a mesh as it is now; valid until end_cycle().
  render::Structures& of(const query::CommittedMesh& mesh);
  /// Gives back what the cycle's frames of a mesh did without, and all of meshes that are gone. In
  /// a cycle without a frame of a mesh, what is there stays.
  void end_cycle(std::span<query::CommittedMesh* const> meshes);

  /// Of all meshes, so far.
  render::Structures::Counts counts() const;

private:
  struct Entry {
    std::unique_ptr<render::Structures> structures;
    bool begun = false;
  };
  core::Memory* memory_;
  const core::Threads* threads_;
  std::map<std::uint64_t, Entry> by_mesh_; ///< by CommittedMesh::id()
  render::Structures::Counts gone_;        ///< of meshes that are gone
};

} // namespace insitu::scene

#pragma once

#include <utility>

#include "commit/committed_mesh.h"
#include "parallel/world.h"

namespace insitu::test {

/// A process's mesh, and the part of a whole one that it is made of. Part(arguments..., rank).
template <class Part>
struct PartOfMesh {
  template <class... Arguments>
  explicit PartOfMesh(parallel::World& world_, Arguments&&... arguments)
      : world(world_), part(std::forward<Arguments>(arguments)..., world.rank()) {
    mesh.mesh().set_is_part(world.size() > 1);
  }

  parallel::World& world;
  core::Memory memory;
  core::Threads threads{1};
  core::Log log{insitu_log_level(0), nullptr, nullptr};
  Part part; ///< whose arrays the mesh has
  commit::CommittedMesh mesh{"part", memory};
};

} // namespace insitu::test

#pragma once

#include <cstdint>

#include "commit/committed_mesh.h"
#include "core/context.h"
#include "core/parallel.h"

namespace insitu::scene {

/// A mesh that frames draw in the place of a solver's: its cells, ghosts and fields are the
/// solver's arrays, read in place, and it has a tree of its own.
class SharedMesh {
public:
  SharedMesh(const std::string& name, core::Memory& memory) : drawn_(name, memory) {}

  /// To be set before the first update().
  commit::CommittedMesh& drawn() { return drawn_; }

  /// Brings it up to date with `own`, the solver's mesh, which is committed: the tree is refitted
  /// or rebuilt only if own's changed since. points(): if vertices moved, those in the place of
  /// own's (mesh::Mesh::share); not called otherwise. Throws core::Error.
  commit::CommittedMesh& update(const commit::CommittedMesh& own, core::Context& context,
                                core::FunctionRef<const math::Vec3d*()> points);

private:
  commit::CommittedMesh drawn_;
  const math::Vec3d* points_ = nullptr;
  std::uint64_t geometry_ = 0, topology_ = 0, fields_ = 0; ///< versions of own
};

} // namespace insitu::scene

#pragma once

#include "advect/field/homes.h"
#include "commit/committed_mesh.h"

namespace insitu::scene {

/// The processes that own the cells of a mesh that has a halo.
class MeshHomes final : public advect::Homes {
public:
  /// The mesh must outlive the object, and stay as it is.
  explicit MeshHomes(const commit::CommittedMesh& mesh) : mesh_(mesh) {}

  bool is_own(std::int64_t cell) const override { return mesh_.mesh().view().is_own(cell); }
  mesh::CellName name(std::int64_t cell) const override { return mesh_.located_name(cell); }
  std::int64_t find(const mesh::CellName& name) const override { return mesh_.find_located(name); }

private:
  const commit::CommittedMesh& mesh_;
};

} // namespace insitu::scene

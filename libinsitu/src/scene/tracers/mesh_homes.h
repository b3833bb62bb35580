#pragma once

#include "advect/field/homes.h"
#include "commit/committed_mesh.h"

namespace insitu::scene {

/// The processes that own the cells of a mesh that has a halo.
class MeshHomes final : public advect::Homes {
public:
  /// The mesh must outlive the object, and stay as it is.
  explicit MeshHomes(const commit::CommittedMesh& mesh)
      : mesh_(mesh), own_(mesh.mesh().own_view().own_cell_count()) {}

  bool is_own(std::int64_t cell) const override { return cell < own_; }
  advect::CellName name(std::int64_t cell) const override {
    const commit::CellName name = mesh_.name(cell);
    return {name.rank, name.piece, name.cell};
  }
  std::int64_t find(const advect::CellName& name) const override {
    return mesh_.find({-1, name.rank, name.piece, name.cell});
  }

private:
  const commit::CommittedMesh& mesh_;
  const std::int64_t own_;
};

} // namespace insitu::scene

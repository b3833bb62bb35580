#pragma once

#include <cstdint>

#include "amr/dual/dual_mesh.h"
#include "parallel/world.h"

namespace insitu::commit {

/// The cells of a dual mesh that is spread over processes in one order: each has a number, the same
/// wherever it exists, and numbers ascend with the ids on every process.
class DualOrder {
public:
  /// Collective, after the dual was built on all. Throws parallel::AgreedError where the mesh is so
  /// wide that numbers do not fit 63 bits.
  void build(const amr::DualMesh& dual, parallel::World& world);

  std::int64_t number(const amr::DualMesh& dual, std::int64_t flat) const;
  /// The cell of that number; -1: it is not here.
  std::int64_t find(const amr::DualMesh& dual, std::int64_t number) const;

private:
  std::int64_t find_in_gridlets(const amr::DualMesh& dual, std::int64_t number) const;
  std::int64_t find_beside(const amr::DualMesh& dual, std::int64_t number) const;

  static constexpr int depths = mesh::Lattice::most_depth + 1;
  std::int64_t first_[depths][3] = {}, count_[depths][3] = {}; ///< bricks, of all processes
  bool has_gridlets_ = false;
};

} // namespace insitu::commit

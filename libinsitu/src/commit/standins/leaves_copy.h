#pragma once

#include <cstdint>
#include <vector>

#include "amr/leaves/leaf_map.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::commit {

/// The cells of an adaptive mesh by `nearest`, as its map of leaves tells them, so that they
/// outlive the solver's arrays: 13 bytes a cell.
class LeavesCopy {
public:
  /// first_cell: of the mesh's pieces, [piece count + 1]. The map is not needed any longer.
  LeavesCopy(const amr::LeafMap& map, std::vector<std::int64_t> first_cell, core::Memory& memory,
             const core::Threads& threads);
  LeavesCopy(const LeavesCopy&) = delete;

  const mesh::MeshView& view() const { return view_; }

private:
  void read(const amr::LeafMap& map, const core::Threads& threads);
  void set_views(const mesh::Lattice& lattice);

  core::Buffer<std::int8_t> depths_;    ///< [flat cell]
  core::Buffer<std::int32_t> corners_;  ///< [flat cell][axis], on the cell's own depth
  core::Buffer<std::uint64_t> covered_; ///< a bit a flat cell: by finer cells
  std::vector<std::int64_t> first_cell_, first_vertex_;
  std::vector<mesh::AmrPieceView> amr_pieces_;
  mesh::AmrView amr_;
  std::vector<mesh::LeavesView> leaves_;
  std::vector<mesh::PieceView> pieces_;
  mesh::MeshView view_;
};

} // namespace insitu::commit

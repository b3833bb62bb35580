#pragma once

#include <cstdint>
#include <vector>

#include "amr/leaves/leaf_map.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/cell_name.h"
#include "mesh/registered/mesh.h"
#include "parallel/world.h"
#include "query/directory.h"

namespace insitu::commit {

/// A leaf of an adaptive mesh as processes tell each other.
struct ToldLeaf {
  mesh::CellName name;
  std::int32_t index[3]; ///< of its depth's cells
  std::int8_t depth;
  std::uint8_t ghosts; ///< a bit a face (2 axis + side) across which the solver has a ghost cell
  std::int16_t padding = 0;

  mesh::AmrCell cell() const { return {depth, {index[0], index[1], index[2]}}; }
};

/// Leaves of other processes as a piece of an adaptive mesh.
class ToldLeaves {
public:
  explicit ToldLeaves(std::span<const ToldLeaf> leaves);
  /// Valid until the object goes.
  mesh::AmrPieceView view() const;
  /// Of ghost cells across faces, in the order of leaves and faces.
  std::int64_t ghost_count() const { return ghosts_; }

private:
  std::vector<std::int8_t> depths_;
  std::vector<std::int32_t> corners_;     ///< [leaf][axis]
  std::vector<std::int32_t> ghost_items_; ///< [leaf][face]; empty: none has any
  std::int64_t ghosts_ = 0;
};

/// Places beside leaves that no leaf of any process covers, as wide as the leaf, beyond which
/// another process has leaves: where a layer of cells was left out between them. A domain may have
/// such a slot, too.
struct LeafGaps {
  std::int64_t count = 0;    ///< faces of this process's leaves
  mesh::CellName own, other; ///< of the first, if there is one
};

/// Finds, on all processes at once, the leaves of others that surround a process's own: those that
/// touch one of them, by a face, an edge or a corner, and those that touch these, in so many
/// layers. All steps are collective.
class LeafSearch {
public:
  /// mesh: adaptive, as of an update() without a halo; on a process without cells it may be any. It
  /// must outlive the object.
  LeafSearch(const mesh::Mesh& mesh, parallel::World& world, core::Memory& memory,
             const core::Threads& threads);

  /// Throws parallel::AgreedError that names both leaves where those of two processes overlap, and
  /// the processes whose lattices differ.
  void find(int layers);

  std::vector<ToldLeaf> near;         ///< those that touch, by process, piece and cell
  std::vector<ToldLeaf> far;          ///< the others, in the same order
  LeafGaps gaps;
  std::vector<std::uint64_t> covered; ///< see mesh::AmrView; empty: none

private:
  void require_one_lattice();
  void gather_boxes();
  void find_covered();
  void find_near();
  void find_gaps();
  void add_layer(std::vector<ToldLeaf>& frontier);
  mesh::Box box_of(const mesh::AmrCell& cell) const;
  ToldLeaf told(std::int64_t flat) const;
  void require_apart(const ToldLeaf& other) const;
  bool is_patched() const;

  const mesh::Mesh& mesh_;
  parallel::World& world_;
  core::Memory& memory_;
  const core::Threads& threads_;
  mesh::AmrView view_;         ///< of the own pieces
  std::int64_t no_cells_ = 0;  ///< first_cell of a mesh that is not adaptive
  query::Directory directory_; ///< of leaves
  amr::LeafMap own_, around_;  ///< of the own leaves; with those that touch them
};

} // namespace insitu::commit

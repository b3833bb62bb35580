#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "amr/leaves/leaf_map.h"
#include "commit/halo/cell_pairs.h"
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

/// Finds, on all processes at once, the leaves of others that surround a process's own: those that
/// touch one of them, by a face, an edge or a corner, and those that touch these, in so many
/// layers. All steps are collective.
class LeafSearch {
public:
  /// mesh: adaptive, as of an update() without a halo; on a process without cells it may be any. It
  /// must outlive the object. own: of the mesh's leaves, where that is there; or null.
  LeafSearch(const mesh::Mesh& mesh, const amr::LeafMap* own, parallel::World& world,
             core::Memory& memory, const core::Threads& threads);

  /// Throws parallel::AgreedError that names both leaves where those of two processes overlap, and
  /// the processes whose lattices differ.
  void find(int layers);

  std::vector<ToldLeaf> near;         ///< those that touch, by process, piece and cell
  std::vector<ToldLeaf> far;          ///< the others, in the same order
  std::vector<ToldLeaf> outermost;    ///< of these, those of the last layer
  /// Places beside leaves that no leaf of any process covers, as wide as the leaf or twice as wide,
  /// beyond which another process has leaves: where a layer of cells was left out between them. A
  /// domain may have such a slot, too. Pairs, one a face of this process's leaves.
  CellPairs gaps;
  std::vector<std::uint64_t> covered; ///< see mesh::AmrView; empty: none

private:
  void require_one_lattice();
  void gather_boxes();
  void find_covered();
  void find_near();
  void find_gaps();
  void add_layer(std::vector<ToldLeaf>& frontier);
  /// Calls f(flat, cell, ranks) for each own leaf whose box, larger on all sides by so many times
  /// its size, meets boxes of these processes.
  template <class F>
  void for_leaves_beside(double sizes, F&& f) const;
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
  std::int64_t run_ = 1;       ///< of this many cells each is a box of this process
  query::Directory directory_; ///< of leaves
  const amr::LeafMap* own_;    ///< of the own leaves
  amr::LeafMap made_, near_;   ///< the same if it was not there; of `near`, by their places there
};

template <class F>
void LeafSearch::for_leaves_beside(double sizes, F&& f) const {
  struct Beside {
    int rank;
    mesh::Box all; ///< of the boxes
    std::vector<mesh::Box> boxes;
  };
  const auto larger = [](const mesh::Box& box, const math::Vec3d& by) {
    return mesh::Box{box.low - by, box.high + by};
  };
  const math::Vec3d coarsest = sizes * box_of({0, {0, 0, 0}}).size();
  std::vector<Beside> beside; // of a run's leaves
  std::vector<int> ranks;
  for (std::int64_t flat = 0; flat < view_.cell_count(); ++flat) {
    if (flat % run_ == 0) {
      const mesh::Box run =
          larger(directory_.boxes(world_.rank())[std::size_t(flat / run_)], coarsest);
      beside.clear();
      for (int r = 0; r < world_.size(); ++r)
        for (const mesh::Box& box : directory_.boxes(r)) {
          if (r == world_.rank() || !mesh::meet(run, box))
            continue;
          if (beside.empty() || beside.back().rank != r)
            beside.push_back({r, box, {}});
          beside.back().all.extend(box);
          beside.back().boxes.push_back(box);
        }
    }
    if (beside.empty())
      continue;
    const mesh::AmrCell cell = amr::cell_at(view_, flat);
    const mesh::Box own = box_of(cell), box = larger(own, sizes * own.size());
    ranks.clear();
    for (const Beside& b : beside)
      if (mesh::meet(box, b.all) && std::ranges::any_of(b.boxes, [&](const mesh::Box& other) {
            return mesh::meet(box, other);
          }))
        ranks.push_back(b.rank);
    if (!ranks.empty() && own_->at(cell.depth, cell.index) == std::uint32_t(flat))
      f(flat, cell, std::span<const int>(ranks));
  }
}

} // namespace insitu::commit

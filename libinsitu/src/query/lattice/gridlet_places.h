#pragma once

#include <cstdint>

#include "amr/leaves/leaf_map.h"
#include "mesh/gridlet.h"
#include "parallel/world.h"

namespace insitu::query {

/// Where the gridlets of a dual mesh are: at most one in the place of each brick of its leaf map.
class GridletPlaces {
public:
  explicit GridletPlaces(core::Memory& memory)
      : in_brick_(memory, INSITU_MEMORY_AMR), covers_(memory, INSITU_MEMORY_AMR),
        all_full_(memory, INSITU_MEMORY_AMR) {}

  /// The arguments but the threads must outlive the object, or its next build.
  void build(const mesh::GridletsView& gridlets, const amr::LeafMap& leaves,
             const core::Threads& threads);

  /// After build(): bounds on rounding are those of other gridlets, too.
  void reach_as(const GridletPlaces& other);
  /// Collective, after build(): bounds on rounding become those of all processes.
  void share_farthest(parallel::World& world);

  /// Until the next build the object must not be asked.
  void release();

  const mesh::GridletsView& gridlets() const { return *gridlets_; }
  /// Of the gridlets, full or not; the dual's other cells come next.
  std::int64_t cell_count() const { return gridlets_->count * mesh::Gridlet::most_cells; }
  std::int64_t bytes() const {
    return std::int64_t(in_brick_.bytes() + covers_.bytes() + all_full_.bytes());
  }

  /// Lengths of a depth, by axis.
  struct Steps {
    double half_cell[3];
    double a_unit[3]; ///< cells
    /// Some units in the last place of any coordinate of a gridlet, of zero's and of the lattice's
    /// origin, in cells: nearer to a face, an index found by either may be the neighbour's.
    double rounding[3];
  };
  const Steps& steps(int depth) const { return steps_[depth]; }

  /// The gridlet in whose place the cell of a depth lies, or -1.
  std::int64_t find(int depth, const std::int64_t* index) const {
    const std::uint32_t brick = store_->find(depth, amr::BrickStore::key_of(index));
    return brick == amr::BrickTable::none ? -1 : std::int64_t(in_brick_[brick]);
  }

  /// Whether all cells of a gridlet are full.
  bool all_full(std::int64_t gridlet) const {
    return (all_full_[std::size_t(gridlet >> 6)] >> (gridlet & 63)) & 1;
  }

  /// Depths that have leaves: [0, depth_count()).
  int depth_count() const { return store_->depth_count(); }
  /// Where to look for the leaf at a cell of a depth: 0 if that is one, 1 at finer depths, -1 at
  /// coarser ones, if anywhere.
  int way_to_leaf(int depth, const std::int64_t* index) const {
    const std::uint32_t brick = store_->find(depth, amr::BrickStore::key_of(index));
    if (brick == amr::BrickTable::none)
      return -1;
    const Cover& cover = covers_[brick].layer[index[2] & 7];
    const int bit = int((index[0] & 7) | (index[1] & 7) << 3);
    return (cover.leaf >> bit) & 1 ? 0 : (cover.finer >> bit) & 1 ? 1 : -1;
  }

private:
  /// Cells of a layer of a brick, a bit each.
  struct Cover {
    std::uint64_t leaf, finer; ///< is a leaf; finer ones lie there
  };
  /// What leaves' ids tell as well, in a sixteenth of the memory.
  struct Covers {
    Cover layer[8];
  };

  const mesh::GridletsView* gridlets_ = nullptr;
  const amr::BrickStore* store_ = nullptr;
  core::Buffer<std::int32_t> in_brick_;  ///< gridlets, or -1
  core::Buffer<Covers> covers_;          ///< of bricks
  core::Buffer<std::uint64_t> all_full_; ///< a bit a gridlet
  Steps steps_[mesh::Lattice::most_depth + 1] = {};
  double farthest_[3] = {0, 0, 0}; ///< of coordinates, from zero and from the lattice's origin
  void set_steps(const mesh::Lattice& lattice);
};

} // namespace insitu::query

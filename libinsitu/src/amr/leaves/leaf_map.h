#pragma once

#include <cstdint>

#include "amr/leaves/brick_numbering.h"
#include "amr/leaves/brick_store.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/adaptive.h"

namespace insitu::amr {

/// Which leaf lies at a place of a depth's lattice: bricks of 8x8x8 entries, a table of bricks a
/// depth. A leaf is a cell that no finer cell covers; its id is its flat cell id. Cells under finer
/// ones are masked here and nowhere else.
class LeafMap {
public:
  static constexpr std::uint32_t nothing = BrickStore::nothing; ///< outside, or in a coarser leaf
  static constexpr std::uint32_t refined = BrickStore::refined; ///< finer cells lie here
  static constexpr int side = 8;

  explicit LeafMap(core::Memory& memory) : store_(memory), numbering_(memory) {}

  /// Builds anew. Throws INSITU_ERROR_MESH that names pieces and cells: cells of one depth at one
  /// place; finer cells that cover a coarser one in part only (a leaf needs all of its place).
  /// After a throw the map is empty.
  void build(const mesh::AmrView& mesh, const core::Threads& threads);
  /// For many queries of leaves at points: see numbering(). Until the next build.
  void number_bricks(const core::Threads& threads) { numbering_.build(store_, threads); }

  const mesh::Lattice& lattice() const { return lattice_; }
  /// Depths that hold leaves: [0, depth_count()).
  int depth_count() const { return store_.depth_count(); }
  std::int64_t leaf_count() const { return leaf_count_; }     ///< masked cells left out
  std::int64_t masked_count() const { return masked_count_; } ///< cells under finer ones
  std::int64_t bytes() const { return store_.bytes() + numbering_.bytes(); }

  /// The leaf's id at an index of a depth, or nothing or refined.
  std::uint32_t at(int depth, const std::int64_t* index) const {
    const std::uint32_t entry = store_.at(depth, index);
    return entry == BrickStore::refined_in_part ? refined : entry;
  }
  const BrickStore& store() const { return store_; }
  /// Empty without number_bricks().
  const BrickNumbering& numbering() const { return numbering_; }

  /// A leaf, with its place.
  struct Leaf {
    std::uint32_t id = nothing;
    mesh::AmrCell cell;
    explicit operator bool() const { return id != nothing; }
  };
  /// The leaf that covers this cell of a depth: of its depth or coarser; none outside, or where the
  /// place is refined.
  Leaf cover(int depth, const std::int64_t* index) const;
  /// The leaf that owns a point: cells are closed below and open above, and the last ones closed
  /// (`nearest` reconstruction). None outside and for points that are not finite.
  Leaf find(const math::Vec3d& p) const;
  /// Of the closed leaves that hold a point, the one with the lowest id; none as find().
  Leaf lowest(const math::Vec3d& p) const {
    return first(p, [](std::uint32_t a, std::uint32_t b) { return a < b; });
  }
  /// The same of any order: is_before(id, other); `other` may be `nothing`, which comes last.
  Leaf first(const math::Vec3d& p,
             core::FunctionRef<bool(std::uint32_t, std::uint32_t)> is_before) const;

private:
  bool finest_index(const math::Vec3d& p, std::int64_t* index, int* on_face) const;
  Leaf descend(const std::int64_t* finest) const;

  mesh::Lattice lattice_;
  BrickStore store_;
  BrickNumbering numbering_;
  std::int64_t leaf_count_ = 0, masked_count_ = 0;
};

} // namespace insitu::amr

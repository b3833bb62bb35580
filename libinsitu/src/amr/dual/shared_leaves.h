#pragma once

#include <algorithm>
#include <cstdint>
#include <span>

#include "amr/dual/cell_runs.h"
#include "mesh/adaptive.h"
#include "parallel/world.h"

namespace insitu::amr {

/// A leaf of this process that another one has among its halo's.
struct LentLeaf {
  std::uint32_t leaf; ///< its flat id here
  std::int32_t rank;
  auto operator<=>(const LentLeaf&) const = default;
};

/// A mesh that is spread over processes, each of which has its own leaves and those of others
/// around them (AmrView::halo_piece_count). All processes build their parts of its dual at once,
/// and each gets, at its leaves, the cells that one process would make of all leaves, to the bit.
struct SharedLeaves {
  parallel::World& world;
  const mesh::AmrView& mesh;
  std::span<const LentLeaf> lent; ///< ascending
  /// A bit for each leaf from mesh.near_cell_count() on: what lies around it is not all known.
  const std::uint64_t* outermost;

  bool is_own(std::uint32_t leaf) const { return leaf < mesh.own_cell_count(); }
  /// Whose leaf it is, of the halo's.
  int rank_of(std::uint32_t leaf) const { return mesh.pieces[piece_of(mesh, leaf)].rank; }
  /// Calls f(rank) for the processes that have a leaf of this one.
  template <class F>
  void for_borrowers(std::uint32_t leaf, F&& f) const {
    for (auto at = std::ranges::lower_bound(lent, LentLeaf{leaf, 0});
         at != lent.end() && at->leaf == leaf; ++at)
      f(at->rank);
  }
};

/// Work that may fail, of one process or of all that share the mesh.
template <class Work>
void agree_after(const SharedLeaves* shared, Work&& work) {
  if (shared)
    shared->world.agree_after(work);
  else
    work();
}

/// A count over all processes that share the mesh.
inline std::int64_t sum_over(const SharedLeaves* shared, std::int64_t count) {
  if (shared)
    shared->world.reduce(std::span(&count, 1), parallel::Reduction::sum);
  return count;
}

} // namespace insitu::amr

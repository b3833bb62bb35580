/// Layers of cells that are missing between the leaves of two processes.
#include <algorithm>

#include "amr/dual/cell_runs.h"
#include "commit/halo/leaf_search.h"
#include "commit/halo/touching_leaves.h"
#include "parallel/parcels.h"

namespace insitu::commit {

using mesh::AmrCell;
using parallel::Parcel;

namespace {

/// The leaf of one process, and that which another one has beyond a gap.
struct Pair {
  mesh::CellName own, other;
};

} // namespace

/// Processes are asked for leaves two cells further on, where the next place is no leaf's. All that
/// touch a leaf are known here.
void LeafSearch::find_gaps() {
  std::vector<Parcel> parcels;
  world_.agree_after([&] {
    std::vector<std::vector<ToldLeaf>> to(std::size_t(world_.size()));
    const auto may_have = [&](int rank, const mesh::Box& box) {
      return std::ranges::any_of(directory_.boxes(rank),
                                 [&](const mesh::Box& b) { return mesh::meet(box, b); });
    };
    for_leaves_beside(2.0, [&](std::int64_t flat, const AmrCell& cell, std::span<const int> ranks) {
      for (int face = 0; face < 6; ++face) {
        const int axis = face >> 1, step = face & 1 ? 1 : -1;
        AmrCell beyond = cell;
        beyond.index[axis] += step;
        if (overlapping_leaf(own_->store(), beyond) != amr::BrickStore::nothing ||
            overlapping_leaf(near_.store(), beyond) != amr::BrickStore::nothing)
          continue;
        beyond.index[axis] += step;
        ToldLeaf asked = told(flat);
        asked.index[axis] = std::int32_t(beyond.index[axis]);
        for (const int r : ranks)
          if (may_have(r, box_of(beyond)))
            to[std::size_t(r)].push_back(asked);
      }
    });
    parcels = parallel::parcels_of(to);
  });
  parcels = world_.exchange(parcels);
  world_.agree_after([&] {
    for (Parcel& parcel : parcels) {
      std::vector<Pair> found;
      for (const ToldLeaf& asked : parallel::items_of<ToldLeaf>(parcel.bytes))
        if (const std::uint32_t leaf = overlapping_leaf(own_->store(), asked.cell());
            leaf != amr::BrickStore::nothing)
          found.push_back({asked.name, told(leaf).name});
      parcel.bytes = parallel::bytes_of(found);
    }
    std::erase_if(parcels, [](const Parcel& p) { return p.bytes.empty(); });
  });
  parcels = world_.exchange(parcels);
  world_.agree_after([&] {
    for (const Parcel& parcel : parcels)
      for (const Pair& pair : parallel::items_of<Pair>(parcel.bytes))
        gaps.add(pair.own, pair.other);
  });
}

} // namespace insitu::commit

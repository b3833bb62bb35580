/// Layers of cells that are missing between the leaves of two processes.
#include <algorithm>
#include <tuple>

#include "amr/dual/cell_runs.h"
#include "commit/halo/leaf_search.h"
#include "commit/halo/touching_leaves.h"
#include "parallel/parcels.h"

namespace insitu::commit {

using mesh::AmrCell;
using parallel::Parcel;

namespace {

/// A place some cells beyond a face of a leaf, two of the leaf's width or three.
struct Asked {
  ToldLeaf leaf; ///< with the place's index
  std::int32_t face, steps;
};
/// The leaf of one process, and that which another one has there.
struct Answer {
  mesh::CellName own, other;
  std::int32_t face, steps;

  auto operator<=>(const Answer& b) const {
    return std::tie(own, face, steps, other) <=> std::tie(b.own, b.face, b.steps, b.other);
  }
};

} // namespace

/// Processes are asked for leaves two cells further on and three, where the next place is no
/// leaf's: between leaves of one width a layer may be missing, and between finer ones leaves of
/// twice the width. All that touch a leaf are known here.
void LeafSearch::find_gaps() {
  std::vector<Parcel> parcels;
  world_.agree_after([&] {
    std::vector<std::vector<Asked>> to(std::size_t(world_.size()));
    const auto may_have = [&](int rank, const mesh::Box& box) {
      return std::ranges::any_of(directory_.boxes(rank),
                                 [&](const mesh::Box& b) { return mesh::meet(box, b); });
    };
    const auto is_empty = [&](const AmrCell& place) {
      return overlapping_leaf(own_->store(), place) == amr::BrickStore::nothing &&
             overlapping_leaf(near_.store(), place) == amr::BrickStore::nothing;
    };
    for_leaves_beside(3.0, [&](std::int64_t flat, const AmrCell& cell, std::span<const int> ranks) {
      for (int face = 0; face < 6; ++face) {
        const int axis = face >> 1, step = face & 1 ? 1 : -1;
        AmrCell beyond = cell;
        for (int steps = 2; steps <= 3; ++steps) {
          beyond.index[axis] += step;
          if (!is_empty(beyond))
            break;
          AmrCell place = beyond;
          place.index[axis] += step;
          Asked asked{told(flat), face, steps};
          asked.leaf.index[axis] = std::int32_t(place.index[axis]);
          for (const int r : ranks)
            if (may_have(r, box_of(place)))
              to[std::size_t(r)].push_back(asked);
        }
      }
    });
    parcels = parallel::parcels_of(to);
  });
  parcels = world_.exchange(parcels);
  world_.agree_after([&] {
    for (Parcel& parcel : parcels) {
      std::vector<Answer> found;
      for (const Asked& asked : parallel::items_of<Asked>(parcel.bytes))
        if (const std::uint32_t leaf = overlapping_leaf(own_->store(), asked.leaf.cell());
            leaf != amr::BrickStore::nothing)
          found.push_back({asked.leaf.name, told(leaf).name, asked.face, asked.steps});
      parcel.bytes = parallel::bytes_of(found);
    }
    std::erase_if(parcels, [](const Parcel& p) { return p.bytes.empty(); });
  });
  parcels = world_.exchange(parcels);
  world_.agree_after([&] {
    std::vector<Answer> all;
    for (const Parcel& parcel : parcels)
      for (const Answer& answer : parallel::items_of<Answer>(parcel.bytes))
        all.push_back(answer);
    std::sort(all.begin(), all.end());
    const Answer* last = nullptr; // the nearest leaf beyond a face is the first one
    for (const Answer& answer : all)
      if (!last || std::tie(answer.own, answer.face) != std::tie(last->own, last->face)) {
        last = &answer;
        gaps.add(answer.own, answer.other);
      }
  });
}

} // namespace insitu::commit

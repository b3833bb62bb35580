#include "amr/dual/whole_gridlets.h"

#include <algorithm>
#include <map>
#include <tuple>

#include "parallel/parcels.h"

namespace insitu::amr {

namespace {

using mesh::Gridlet;

/// Which cells of a brick a gridlet has, from its first to its last along each axis.
struct Extent {
  std::int32_t brick[3];
  std::int16_t depth;
  std::uint8_t first[3], end[3];

  BrickKey key() const { return {brick[0], brick[1], brick[2]}; }
  void extend(const Extent& b) {
    for (int a = 0; a < 3; ++a) {
      first[a] = std::min(first[a], b.first[a]);
      end[a] = std::max(end[a], b.end[a]);
    }
  }
};

Extent extent_of(const Gridlet& g) {
  Extent e{};
  e.depth = g.depth;
  for (int a = 0; a < 3; ++a) {
    e.brick[a] = g.lower[a] >> 3;
    e.first[a] = std::uint8_t(g.lower[a] & 7);
    e.end[a] = std::uint8_t(e.first[a] + g.size[a]);
  }
  return e;
}

/// Who brings the parts of a brick's gridlet together.
int keeper(const Extent& e, int processes) {
  std::uint64_t h = std::uint64_t(e.depth);
  for (const std::int32_t k : e.brick)
    h = (h ^ std::uint32_t(k)) * 0x9e3779b97f4a7c15u, h ^= h >> 32;
  return int(h % std::uint64_t(processes));
}

/// Calls f(gridlet, its eight words of full cells).
template <class F>
void for_gridlets(std::vector<DualPart>& parts, F&& f) {
  for (DualPart& part : parts)
    for (std::size_t g = 0; g < part.gridlets.size(); ++g)
      f(part.gridlets[g], &part.full[8 * g]);
}

/// The same full cells, numbered from another lower corner.
void widen(Gridlet& g, std::uint64_t* full, const Extent& to) {
  std::uint64_t moved[8] = {};
  const Extent from = extent_of(g);
  const int di = from.first[0] - to.first[0], dj = from.first[1] - to.first[1],
            dk = from.first[2] - to.first[2];
  for (int k = 0; k < g.size[2]; ++k)
    moved[k + dk] = full[k] << (di + 8 * dj); // rows stay within theirs
  std::copy_n(moved, 8, full);
  for (int a = 0; a < 3; ++a) {
    g.lower[a] = 8 * to.brick[a] + to.first[a];
    g.size[a] = std::uint8_t(to.end[a] - to.first[a]);
  }
}

/// Which leaves are at the vertices of a part's gridlets.
void find_leaves(const BrickStore& store, const std::vector<std::uint32_t>& split, DualPart& part) {
  part.leaves.clear();
  part.empty = -part.cubes;
  for (Gridlet& g : part.gridlets) {
    g.first = std::uint32_t(part.leaves.size());
    part.empty += g.size[0] * g.size[1] * g.size[2];
    for (int k = 0; k <= g.size[2]; ++k)
      for (int j = 0; j <= g.size[1]; ++j)
        for (int i = 0; i <= g.size[0]; ++i) {
          const std::int64_t index[3] = {g.lower[0] + i, g.lower[1] + j, g.lower[2] + k};
          const std::uint32_t id = store.at(g.depth, index);
          part.leaves.push_back(BrickStore::is_leaf(id) && !std::ranges::binary_search(split, id)
                                    ? id
                                    : mesh::GridletsView::no_leaf);
        }
  }
}

} // namespace

void make_gridlets_whole(std::vector<DualPart>& parts, const BrickStore& store,
                         const VirtualLeaves& made, const SharedLeaves& shared) {
  parallel::World& world = shared.world;
  std::vector<parallel::Parcel> parcels;
  world.agree_after([&] {
    std::vector<std::vector<Extent>> to(std::size_t(world.size()));
    for_gridlets(parts, [&](const Gridlet& g, const std::uint64_t*) {
      const Extent e = extent_of(g);
      to[std::size_t(keeper(e, world.size()))].push_back(e);
    });
    parcels = parallel::parcels_of(to);
  });
  parcels = world.exchange(parcels);
  const auto key = [](const Extent& e) {
    return std::tuple(e.depth, e.brick[2], e.brick[1], e.brick[0]);
  };
  world.agree_after([&] {
    std::map<std::tuple<std::int16_t, std::int32_t, std::int32_t, std::int32_t>, Extent> whole;
    for (const parallel::Parcel& p : parcels)
      for (const Extent& e : parallel::items_of<Extent>(p.bytes))
        whole.try_emplace(key(e), e).first->second.extend(e);
    for (parallel::Parcel& p : parcels) {
      std::vector<Extent> back = parallel::items_of<Extent>(p.bytes);
      for (Extent& e : back)
        e = whole.at(key(e));
      p.bytes = parallel::bytes_of(back);
    }
  });
  parcels = world.exchange(parcels);
  world.agree_after([&] {
    std::map<int, std::vector<Extent>> of;
    std::map<int, std::size_t> next;
    for (const parallel::Parcel& p : parcels)
      of[p.rank] = parallel::items_of<Extent>(p.bytes);
    for_gridlets(parts, [&](Gridlet& g, std::uint64_t* full) {
      const int rank = keeper(extent_of(g), world.size());
      widen(g, full, of.at(rank).at(next[rank]++));
    });
    std::vector<std::uint32_t> split;
    for (const VirtualLeaves::Leaf& leaf : made.leaves)
      split.push_back(leaf.real_id);
    std::ranges::sort(split);
    for (DualPart& part : parts)
      if (!part.gridlets.empty())
        find_leaves(store, split, part);
  });
}

} // namespace insitu::amr

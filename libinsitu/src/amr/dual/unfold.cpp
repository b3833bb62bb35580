#include "amr/dual/unfold.h"

#include <algorithm>
#include <array>
#include <iterator>
#include <span>

#include "amr/leaves/balance.h"

namespace insitu::amr {

namespace {

/// The cells that are split now and were not before.
std::vector<mesh::AmrCell> newly_split(const VirtualLeaves& before, const VirtualLeaves& now) {
  std::vector<mesh::AmrCell> out;
  std::set_difference(now.split.begin(), now.split.end(), before.split.begin(), before.split.end(),
                      std::back_inserter(out), [](const mesh::AmrCell& a, const mesh::AmrCell& b) {
                        return a.depth != b.depth ? a.depth < b.depth
                                                  : comes_before(a.index, b.index);
                      });
  return out;
}

/// Calls f(brick, low, high) for the bricks that a cell touches, or at whose edge it ends: the
/// brick of a key and finer ones inside it. low, high: the corners that the cell touches, from the
/// brick's lowest one; not clipped to the brick.
template <class F>
void for_bricks(const BrickStore& store, const mesh::AmrCell& cell, int depth, const BrickKey& key,
                F&& f) {
  const std::uint32_t brick = store.find(depth, key);
  if (brick == BrickTable::none)
    return;
  const std::int32_t at[3] = {key.x, key.y, key.z};
  std::int64_t low[3], high[3];
  for (int a = 0; a < 3; ++a) {
    const std::int64_t first = std::int64_t(at[a]) * BrickStore::side;
    low[a] = (cell.index[a] << (depth - cell.depth)) - first;
    high[a] = ((cell.index[a] + 1) << (depth - cell.depth)) - first;
    if (high[a] < 0 || low[a] > BrickStore::side)
      return;
  }
  f(brick, low, high);
  for (int child = 0; child < 8 && depth + 1 < store.depth_count(); ++child)
    for_bricks(store, cell, depth + 1,
               {2 * key.x + (child & 1), 2 * key.y + (child >> 1 & 1), 2 * key.z + (child >> 2)},
               f);
}
template <class F>
void for_bricks(const BrickStore& store, const std::vector<mesh::AmrCell>& cells, F&& f) {
  for (const mesh::AmrCell& cell : cells) {
    const std::int64_t lowest[3] = {cell.index[0] - 1, cell.index[1] - 1, cell.index[2] - 1},
                       highest[3] = {cell.index[0] + 1, cell.index[1] + 1, cell.index[2] + 1};
    const BrickKey low = BrickStore::key_of(lowest), high = BrickStore::key_of(highest);
    for (std::int32_t z = low.z; z <= high.z; ++z)
      for (std::int32_t y = low.y; y <= high.y; ++y)
        for (std::int32_t x = low.x; x <= high.x; ++x)
          for_bricks(store, cell, cell.depth, {x, y, z}, f);
  }
}

/// The corners that cells touch.
class TouchedCorners {
public:
  TouchedCorners(const BrickStore& store, const std::vector<mesh::AmrCell>& cells)
      : store_(store), layers_(std::size_t(store.brick_count())) {
    for_bricks(store, cells,
               [&](std::uint32_t brick, const std::int64_t* low, const std::int64_t* high) {
                 add(layers_[brick], low, high);
               });
  }
  /// True, too, where there is no brick: leaves below alone may touch the corner.
  bool holds(int depth, const std::int64_t* corner) const {
    const std::uint32_t brick = store_.find(depth, BrickStore::key_of(corner));
    return brick == BrickTable::none ||
           (layers_[brick][std::size_t(corner[2] & 7)] >> ((corner[0] & 7) | (corner[1] & 7) << 3) &
            1) != 0;
  }

private:
  using Layers = std::array<std::uint64_t, 8>; ///< of a brick's corners, a bit each: i + 8 j

  static void add(Layers& layers, const std::int64_t* low, const std::int64_t* high) {
    int first[3], last[3];
    for (int a = 0; a < 3; ++a) {
      first[a] = int(std::max<std::int64_t>(low[a], 0));
      last[a] = int(std::min<std::int64_t>(high[a], 7));
      if (first[a] > last[a])
        return;
    }
    const std::uint64_t row = (2u << last[0]) - (1u << first[0]);
    std::uint64_t layer = 0;
    for (int j = first[1]; j <= last[1]; ++j)
      layer |= row << (8 * j);
    for (int k = first[2]; k <= last[2]; ++k)
      layers[std::size_t(k)] |= layer;
  }

  const BrickStore& store_;
  std::vector<Layers> layers_;
};

/// Looks at a corner once more in a map with splits.
SteepCorner look_again(const BrickStore& split, const mesh::Lattice& lattice,
                       const SteepCorner& steep) {
  Corner corner;
  if (!corner_at(split, steep.depth, steep.index, corner) || corner.most_up <= 1) {
    SteepCorner gone = steep;
    gone.octants = 0;
    gone.folded = false;
    return gone;
  }
  DualCells& cells = DualCells::of_thread();
  DualCell cell;
  if (cells.make(corner, cell))
    return {corner, cells.folds()};
  DualPart part;
  return {corner, split_reentrant(corner, lattice, part.cells, part.means)};
}

/// The same of those that splits touch; the others do not fold any more.
void look_again(const BrickStore& split, const mesh::Lattice& lattice,
                const std::vector<mesh::AmrCell>& splits, std::vector<SteepCorner>& steep,
                const core::Threads& threads) {
  const TouchedCorners touched(split, splits);
  threads.parallel_for(std::int64_t(steep.size()), 256, [&](std::int64_t begin, std::int64_t end) {
    for (SteepCorner& c : std::span(steep).subspan(std::size_t(begin), std::size_t(end - begin)))
      if (touched.holds(c.depth, c.index))
        c = look_again(split, lattice, c);
      else
        c.folded = false;
  });
}

} // namespace

std::vector<char> changed_bricks(const BrickStore& store, const std::vector<mesh::AmrCell>& split) {
  std::vector<char> changed(std::size_t(store.brick_count()), 0);
  for_bricks(store, split, [&](std::uint32_t brick, const std::int64_t*, const std::int64_t*) {
    changed[brick] = 1;
  });
  return changed;
}

VirtualLeaves unfold(const BrickStore& store, const mesh::Lattice& lattice,
                     std::vector<SteepCorner> steep, std::int64_t real, BrickStore& split,
                     const core::Threads& threads, const SharedLeaves* shared) {
  // A split can leave a cell folded that has another coarse leaf, and fold others. Every round
  // splits more; after some, all that is steep is taken together, after which nothing folds.
  constexpr int most_local_rounds = 6;
  VirtualLeaves made;
  made.first = real;
  std::vector<SteepCorner> corners;
  for (int round = 0;; ++round) {
    const bool is_last = round > most_local_rounds;
    const std::size_t before = corners.size();
    agree_after(shared, [&] {
      std::copy_if(steep.begin(), steep.end(), std::back_inserter(corners),
                   [&](const SteepCorner& c) { return is_last || c.folded; });
    });
    if (sum_over(shared, std::int64_t(corners.size() - before)) == 0 && round > 0)
      return made;
    VirtualLeaves more = balance(store, corners, real, shared);
    agree_after(shared, [&] {
      overlay(store, more, split, threads);
      if (!is_last)
        look_again(split, lattice, newly_split(made, more), steep, threads);
      made = std::move(more);
    });
    if (is_last)
      return made;
  }
}

} // namespace insitu::amr

#include "amr/dual_parts.h"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "amr/balance.h"

namespace insitu::amr {

namespace {

constexpr std::int64_t bricks_a_part = 32;

/// The parts of some bricks.
std::vector<DualPart> enumerate_parts(const BrickStore& store, const mesh::Lattice& lattice,
                                      const std::vector<std::uint32_t>& bricks, std::int64_t real,
                                      const core::Threads& threads) {
  const std::int64_t n = std::int64_t(bricks.size());
  std::vector<DualPart> parts(std::size_t((n + bricks_a_part - 1) / bricks_a_part));
  threads.parallel_for(n, bricks_a_part, [&](std::int64_t begin, std::int64_t end) {
    enumerate(store, lattice, {bricks.data() + begin, std::size_t(end - begin)}, real,
              parts[std::size_t(begin / bricks_a_part)]);
  });
  return parts;
}

/// The bricks whose dual cells the splits change: those around a leaf that was split, and finer
/// ones inside them.
std::vector<char> changed_bricks(const BrickStore& store, const VirtualLeaves& made) {
  std::vector<char> changed(std::size_t(store.brick_count()), 0);
  for (std::size_t v = 0; v < made.leaves.size(); ++v) {
    const VirtualLeaves::Leaf& leaf = made.leaves[v];
    if (v > 0 && leaf.real_id == made.leaves[v - 1].real_id)
      continue;
    for (int n = 0; n < 27; ++n) {
      const std::int64_t index[3] = {leaf.real.index[0] + n % 3 - 1,
                                     leaf.real.index[1] + n / 3 % 3 - 1,
                                     leaf.real.index[2] + n / 9 - 1};
      const std::uint32_t brick = store.find(leaf.real.depth, BrickStore::key_of(index));
      if (brick != BrickTable::none)
        changed[brick] = 1;
    }
  }
  for (int d = 1; d < store.depth_count(); ++d)
    for (std::int64_t b = store.first_brick(d); b < store.first_brick(d + 1); ++b)
      changed[std::size_t(b)] |= changed[store.find(d - 1, store.key(b).parent())];
  return changed;
}

/// Empties the parts that hold changed bricks; returns all bricks of these, as `split` numbers
/// them, and the ones that only it has.
std::vector<std::uint32_t> drop_changed(const BrickStore& store, const VirtualLeaves& made,
                                        const BrickStore& split, std::vector<DualPart>& parts) {
  const std::vector<char> changed = changed_bricks(store, made);
  std::vector<char> keep(std::size_t(split.brick_count()), 0);
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const std::int64_t begin = std::int64_t(p) * bricks_a_part,
                       end = std::min(begin + bricks_a_part, store.brick_count());
    if (std::find(changed.begin() + begin, changed.begin() + end, 1) != changed.begin() + end) {
      parts[p] = {};
      continue;
    }
    for (std::int64_t b = begin; b < end; ++b)
      keep[split.find(store.depth_of(b), store.key(b))] = 1;
  }
  std::vector<std::uint32_t> again;
  for (std::size_t b = 0; b < keep.size(); ++b)
    if (!keep[b])
      again.push_back(std::uint32_t(b));
  return again;
}

/// Adds the corners whose cells fold, or all steep ones; returns how many cells fold.
std::int64_t add_corners(const std::vector<DualPart>& parts, bool all,
                         std::vector<SteepCorner>& corners) {
  std::int64_t folded = 0;
  for (const DualPart& part : parts) {
    folded += part.folded;
    if (all || part.folded > 0)
      std::copy_if(part.steep.begin(), part.steep.end(), std::back_inserter(corners),
                   [&](const SteepCorner& c) { return all || c.folded; });
  }
  return folded;
}

} // namespace

DualParts make_dual_parts(const BrickStore& store, const mesh::Lattice& lattice, std::int64_t real,
                          core::Memory& memory, const core::Threads& threads) {
  DualParts dual;
  dual.made.first = real;
  std::vector<std::uint32_t> bricks(std::size_t(store.brick_count()));
  std::iota(bricks.begin(), bricks.end(), 0u);
  dual.parts = enumerate_parts(store, lattice, bricks, real, threads);
  std::vector<SteepCorner> corners;
  dual.folded = dual.still_folded = add_corners(dual.parts, false, corners);
  // A split can leave a cell folded that has another coarse leaf. Every round splits more; after
  // some, all that is steep is taken together, after which nothing folds.
  constexpr int most_local_rounds = 6;
  for (int round = 0; dual.still_folded > 0 && !corners.empty(); ++round) {
    dual.made = balance(store, corners, real);
    BrickStore split(memory);
    overlay(store, dual.made, split, threads);
    bricks = drop_changed(store, dual.made, split, dual.parts);
    std::vector<DualPart> again = enumerate_parts(split, lattice, bricks, real, threads);
    const std::size_t before = corners.size();
    const bool all = round == most_local_rounds;
    dual.still_folded = add_corners(again, all, corners);
    if (all)
      add_corners(dual.parts, all, corners);
    if (dual.still_folded == 0 || corners.size() == before)
      std::move(again.begin(), again.end(), std::back_inserter(dual.parts));
    if (corners.size() == before)
      break;
  }
  return dual;
}

} // namespace insitu::amr

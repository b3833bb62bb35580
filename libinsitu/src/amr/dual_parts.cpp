#include "amr/dual_parts.h"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "amr/balance.h"

namespace insitu::amr {

namespace {

constexpr std::int64_t bricks_a_part = 8;

/// What groups of bricks make of a dual mesh.
struct Enumerated {
  std::vector<DualPart> parts;
  std::vector<std::vector<std::uint32_t>> bricks; ///< each part's, as a store numbers them

  void add(Enumerated&& more) {
    std::move(more.parts.begin(), more.parts.end(), std::back_inserter(parts));
    std::move(more.bricks.begin(), more.bricks.end(), std::back_inserter(bricks));
  }
  std::int64_t folded() const {
    return std::accumulate(parts.begin(), parts.end(), std::int64_t(0),
                           [](std::int64_t sum, const DualPart& p) { return sum + p.folded; });
  }
  /// The corners whose cells fold, or all steep ones.
  void add_corners(bool all, std::vector<SteepCorner>& corners) const {
    for (const DualPart& part : parts)
      if (all || part.folded > 0)
        std::copy_if(part.steep.begin(), part.steep.end(), std::back_inserter(corners),
                     [&](const SteepCorner& c) { return all || c.folded; });
  }
};

Enumerated enumerate_bricks(const BrickStore& store, const mesh::Lattice& lattice,
                            const std::vector<std::uint32_t>& bricks, std::int64_t real,
                            const core::Threads& threads) {
  const std::int64_t n = std::int64_t(bricks.size());
  const auto count = std::size_t((n + bricks_a_part - 1) / bricks_a_part);
  Enumerated out;
  out.parts.resize(count);
  out.bricks.resize(count);
  threads.parallel_for(n, bricks_a_part, [&](std::int64_t begin, std::int64_t end) {
    const auto part = std::size_t(begin / bricks_a_part);
    out.bricks[part].assign(bricks.begin() + begin, bricks.begin() + end);
    enumerate(store, lattice, out.bricks[part], real, out.parts[part]);
  });
  return out;
}

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

/// Flags the bricks that a cell touches, or at whose edge it ends: the brick of a key and finer
/// ones inside it.
void flag_bricks(const BrickStore& store, const mesh::AmrCell& cell, int depth, const BrickKey& key,
                 std::vector<char>& flags) {
  const std::uint32_t brick = store.find(depth, key);
  if (brick == BrickTable::none)
    return;
  const std::int32_t at[3] = {key.x, key.y, key.z};
  for (int a = 0; a < 3; ++a) {
    const std::int64_t first = std::int64_t(at[a]) * BrickStore::side;
    const std::int64_t low = cell.index[a] << (depth - cell.depth), high = (cell.index[a] + 1)
                                                                           << (depth - cell.depth);
    if (first > high || first + BrickStore::side < low)
      return;
  }
  flags[brick] = 1;
  for (int child = 0; child < 8 && depth + 1 < store.depth_count(); ++child)
    flag_bricks(store, cell, depth + 1,
                {2 * key.x + (child & 1), 2 * key.y + (child >> 1 & 1), 2 * key.z + (child >> 2)},
                flags);
}

/// The bricks whose dual cells these splits change: those with leaves that touch a cell that was
/// split. A flag a brick.
std::vector<char> changed_bricks(const BrickStore& store, const std::vector<mesh::AmrCell>& split) {
  std::vector<char> changed(std::size_t(store.brick_count()), 0);
  for (const mesh::AmrCell& cell : split) {
    const std::int64_t lowest[3] = {cell.index[0] - 1, cell.index[1] - 1, cell.index[2] - 1},
                       highest[3] = {cell.index[0] + 1, cell.index[1] + 1, cell.index[2] + 1};
    const BrickKey low = BrickStore::key_of(lowest), high = BrickStore::key_of(highest);
    for (std::int32_t z = low.z; z <= high.z; ++z)
      for (std::int32_t y = low.y; y <= high.y; ++y)
        for (std::int32_t x = low.x; x <= high.x; ++x)
          flag_bricks(store, cell, cell.depth, {x, y, z}, changed);
  }
  return changed;
}

/// The numbers of virtual leaves after another round of splits; none for those split themselves.
std::vector<std::uint32_t> renumbered(const VirtualLeaves& before, const VirtualLeaves& now) {
  std::vector<std::uint32_t> to(before.leaves.size(), BrickStore::nothing);
  // Both are in the order of the cells that they are children of, and of octants.
  const auto comes_first = [](const mesh::AmrCell& a, const mesh::AmrCell& b) {
    if (a.depth != b.depth)
      return a.depth < b.depth;
    const std::int64_t parents[2][3] = {{a.index[0] >> 1, a.index[1] >> 1, a.index[2] >> 1},
                                        {b.index[0] >> 1, b.index[1] >> 1, b.index[2] >> 1}};
    return std::equal(parents[0], parents[0] + 3, parents[1])
               ? comes_before(a.index, b.index)
               : comes_before(parents[0], parents[1]);
  };
  std::size_t n = 0;
  for (std::size_t o = 0; o < before.leaves.size(); ++o) {
    const mesh::AmrCell& cell = before.leaves[o].cell;
    while (n < now.leaves.size() && comes_first(now.leaves[n].cell, cell))
      ++n;
    if (n < now.leaves.size() && !comes_first(cell, now.leaves[n].cell))
      to[o] = std::uint32_t(now.first + std::int64_t(n));
  }
  return to;
}

void renumber(DualPart& part, std::int64_t first_virtual, const std::vector<std::uint32_t>& to) {
  const auto put = [&](std::uint32_t& leaf) {
    if (leaf >= first_virtual)
      leaf = to[std::size_t(leaf - first_virtual)];
  };
  for (DualCell& cell : part.cells)
    for (int v = 0; v < mesh::vertex_count(cell.shape); ++v)
      if (cell.vertices[v].moves != mean_moves)
        put(cell.vertices[v].leaf);
  for (MeanVertex& mean : part.means)
    for (int i = 0; i < mean.count; ++i)
      put(mean.leaves[i]);
}

/// Keeps the parts whose bricks have not changed, with their numbers in another store; returns all
/// its other bricks.
std::vector<std::uint32_t> keep_unchanged(const BrickStore& before, const BrickStore& now,
                                          const std::vector<char>& changed, Enumerated& all) {
  std::vector<char> kept(std::size_t(now.brick_count()), 0);
  Enumerated keep;
  for (std::size_t p = 0; p < all.parts.size(); ++p) {
    std::vector<std::uint32_t>& bricks = all.bricks[p];
    bool same = true;
    for (std::uint32_t& b : bricks) {
      b = now.find(before.depth_of(b), before.key(b));
      same = same && !changed[b];
    }
    if (!same)
      continue;
    for (const std::uint32_t b : bricks)
      kept[b] = 1;
    keep.parts.push_back(std::move(all.parts[p]));
    keep.bricks.push_back(std::move(bricks));
  }
  all = std::move(keep);
  std::vector<std::uint32_t> others;
  for (std::size_t b = 0; b < kept.size(); ++b)
    if (!kept[b])
      others.push_back(std::uint32_t(b));
  return others;
}

} // namespace

DualParts make_dual_parts(const BrickStore& store, const mesh::Lattice& lattice, std::int64_t real,
                          core::Memory& memory, const core::Threads& threads) {
  VirtualLeaves made;
  made.first = real;
  std::vector<std::uint32_t> bricks(std::size_t(store.brick_count()));
  std::iota(bricks.begin(), bricks.end(), 0u);
  Enumerated all = enumerate_bricks(store, lattice, bricks, real, threads);
  std::vector<SteepCorner> corners;
  all.add_corners(false, corners);
  const std::int64_t folded = all.folded();
  std::int64_t still_folded = folded;
  // A split can leave a cell folded that has another coarse leaf. Every round splits more; after
  // some, all that is steep is taken together, after which nothing folds.
  constexpr int most_local_rounds = 6;
  BrickStore overlays[2] = {BrickStore(memory), BrickStore(memory)}; // this round's and the last's
  const BrickStore* split = &store;
  bool is_last = false;
  for (int round = 0; still_folded > 0; ++round) {
    VirtualLeaves more = balance(store, corners, real);
    BrickStore& next = overlays[round & 1];
    overlay(store, more, next, threads);
    bricks = keep_unchanged(*split, next, changed_bricks(next, newly_split(made, more)), all);
    const std::vector<std::uint32_t> to = renumbered(made, more);
    for (DualPart& part : all.parts)
      renumber(part, real, to);
    made = std::move(more);
    split = &next;
    Enumerated again = enumerate_bricks(*split, lattice, bricks, real, threads);
    const std::size_t before = corners.size();
    again.add_corners(false, corners);
    all.add(std::move(again));
    still_folded = all.folded();
    if (is_last)
      break;
    if (round == most_local_rounds || corners.size() == before) {
      all.add_corners(true, corners);
      is_last = true;
    }
  }
  return {std::move(all.parts), std::move(made), folded, still_folded};
}

} // namespace insitu::amr

#include "amr/dual/dual_parts.h"

#include <algorithm>
#include <iterator>
#include <numeric>

#include "amr/dual/unfold.h"

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
  std::vector<SteepCorner> steep() const {
    std::vector<SteepCorner> out;
    for (const DualPart& part : parts)
      out.insert(out.end(), part.steep.begin(), part.steep.end());
    return out;
  }
};

Enumerated enumerate_bricks(const BrickStore& store, const mesh::Lattice& lattice,
                            const std::vector<std::uint32_t>& bricks, std::int64_t real,
                            bool only_unfolded, const core::Threads& threads) {
  const std::int64_t n = std::int64_t(bricks.size());
  const auto count = std::size_t((n + bricks_a_part - 1) / bricks_a_part);
  Enumerated out;
  out.parts.resize(count);
  out.bricks.resize(count);
  threads.parallel_for(n, bricks_a_part, [&](std::int64_t begin, std::int64_t end) {
    const auto part = std::size_t(begin / bricks_a_part);
    out.bricks[part].assign(bricks.begin() + begin, bricks.begin() + end);
    enumerate(store, lattice, out.bricks[part], real, only_unfolded, out.parts[part]);
  });
  return out;
}

/// Keeps the parts whose bricks have not changed, with their numbers in another store; returns all
/// its other bricks.
std::vector<std::uint32_t> keep_unchanged(const BrickStore& before, const BrickStore& now,
                                          const std::vector<char>& changed, Enumerated& all) {
  std::vector<char> kept(std::size_t(now.brick_count()), 0);
  Enumerated keep;
  for (std::size_t p = 0; p < all.parts.size(); ++p) {
    std::vector<std::uint32_t>& bricks = all.bricks[p];
    bool same = all.parts[p].folded == 0;
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
  std::vector<std::uint32_t> bricks(std::size_t(store.brick_count()));
  std::iota(bricks.begin(), bricks.end(), 0u);
  DualParts out;
  out.made.first = real;
  Enumerated all = enumerate_bricks(store, lattice, bricks, real, true, threads);
  out.folded = all.folded();
  if (out.folded > 0) {
    BrickStore split(memory);
    out.made = unfold(store, lattice, all.steep(), real, split, threads);
    bricks = keep_unchanged(store, split, changed_bricks(split, out.made.split), all);
    all.add(enumerate_bricks(split, lattice, bricks, real, false, threads));
    out.still_folded = all.folded();
  }
  out.parts = std::move(all.parts);
  return out;
}

} // namespace insitu::amr

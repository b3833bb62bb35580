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

/// bricks: ascending. Those of a part follow each other.
Enumerated enumerate_bricks(const BrickStore& store, const mesh::Lattice& lattice,
                            const std::vector<std::uint32_t>& bricks, const Real& real,
                            bool only_unfolded, const core::Threads& threads) {
  Enumerated out;
  for (const std::uint32_t b : bricks) {
    if (out.bricks.empty() || out.bricks.back().size() == bricks_a_part ||
        out.bricks.back().back() + 1 != b)
      out.bricks.emplace_back();
    out.bricks.back().push_back(b);
  }
  out.parts.resize(out.bricks.size());
  threads.parallel_for(
      std::int64_t(out.parts.size()), 1, [&](std::int64_t begin, std::int64_t end) {
        for (auto part = std::size_t(begin); part < std::size_t(end); ++part)
          enumerate(store, lattice, out.bricks[part], real, only_unfolded, out.parts[part]);
      });
  return out;
}

/// By bricks, which no two parts share.
void sort_parts(Enumerated& all) {
  std::vector<std::size_t> order(all.parts.size());
  std::iota(order.begin(), order.end(), std::size_t(0));
  std::ranges::sort(order, {}, [&](std::size_t p) { return all.bricks[p].front(); });
  Enumerated sorted;
  for (const std::size_t p : order) {
    sorted.parts.push_back(std::move(all.parts[p]));
    sorted.bricks.push_back(std::move(all.bricks[p]));
  }
  all = std::move(sorted);
}

/// Keeps the parts whose bricks have not changed, and still follow each other, with their numbers
/// in another store; returns all its other bricks.
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
    same = same && bricks.back() - bricks.front() + 1 == bricks.size();
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
                          core::Memory& memory, const core::Threads& threads,
                          const SharedLeaves* shared) {
  Real which(real);
  if (shared) {
    which.near = shared->mesh.near_cell_count();
    which.outermost = shared->outermost;
    which.with_places = true;
  }
  DualParts out;
  out.made.first = real;
  Enumerated all;
  agree_after(shared, [&] {
    std::vector<std::uint32_t> bricks(std::size_t(store.brick_count()));
    std::iota(bricks.begin(), bricks.end(), 0u);
    all = enumerate_bricks(store, lattice, bricks, which, true, threads);
    out.folded = all.folded();
  });
  if (sum_over(shared, out.folded) > 0) {
    BrickStore split(memory);
    out.made = unfold(store, lattice, all.steep(), real, split, threads, shared);
    agree_after(shared, [&] {
      const std::vector<std::uint32_t> others =
          keep_unchanged(store, split, changed_bricks(split, out.made.split), all);
      which.made = &out.made;
      all.add(enumerate_bricks(split, lattice, others, which, false, threads));
      sort_parts(all);
      out.still_folded = all.folded();
    });
  }
  out.parts = std::move(all.parts);
  return out;
}

} // namespace insitu::amr

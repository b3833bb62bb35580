#include "amr/leaves/collect_bricks.h"

#include <atomic>

#include "amr/dual/cell_runs.h"

namespace insitu::amr {

namespace {

using mesh::Lattice;

constexpr int depths = Lattice::most_depth + 1;
constexpr std::int64_t grain = 1 << 16;

/// A range of bricks of a depth, and how many cells it has.
struct Range {
  std::int64_t lower[3], upper[3]; ///< inclusive
  std::int64_t cells = 0;

  void add(const std::int64_t* lo, const std::int64_t* hi) {
    for (int a = 0; a < 3; ++a) {
      lower[a] = cells == 0 ? lo[a] : std::min(lower[a], lo[a]);
      upper[a] = cells == 0 ? hi[a] : std::max(upper[a], hi[a]);
    }
  }
  double volume() const {
    double v = 1.0;
    for (int a = 0; a < 3; ++a)
      v *= double(upper[a] - lower[a] + 1);
    return v;
  }
};
using Ranges = std::array<Range, depths>;

void merge(Range& a, const Range& b) {
  if (b.cells == 0)
    return;
  a.add(b.lower, b.upper);
  a.cells += b.cells;
}

Ranges find_ranges(const mesh::AmrView& mesh, const core::Threads& threads) {
  const std::int64_t n = mesh.cell_count();
  std::vector<Ranges> of_chunk(std::size_t((n + grain - 1) / grain));
  threads.parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
    Ranges& ranges = of_chunk[std::size_t(begin / grain)];
    for_runs(mesh, begin, end,
             [&](int depth, const std::int64_t* index, std::int64_t count, std::int64_t) {
               const std::int64_t lo[3] = {index[0] >> 3, index[1] >> 3, index[2] >> 3};
               const std::int64_t hi[3] = {(index[0] + count - 1) >> 3, lo[1], lo[2]};
               Range& r = ranges[std::size_t(depth)];
               r.add(lo, hi);
               r.cells += count;
             });
  });
  Ranges all;
  for (const Ranges& r : of_chunk)
    for (std::size_t d = 0; d < depths; ++d)
      merge(all[d], r[d]);
  return all;
}

/// One mark a brick of a range.
struct Marks {
  Range range;
  std::vector<std::uint8_t> marks;

  void mark(std::int64_t x, std::int64_t y, std::int64_t z) {
    const std::int64_t* lo = range.lower;
    const std::int64_t* hi = range.upper;
    std::uint8_t& m = marks[std::size_t(
        x - lo[0] + (hi[0] - lo[0] + 1) * (y - lo[1] + (hi[1] - lo[1] + 1) * (z - lo[2])))];
    const std::atomic_ref<std::uint8_t> shared(m);
    if (!shared.load(std::memory_order_relaxed))
      shared.store(1, std::memory_order_relaxed);
  }
  void list(std::vector<BrickKey>& keys) const {
    std::size_t at = 0;
    for (std::int64_t z = range.lower[2]; z <= range.upper[2]; ++z)
      for (std::int64_t y = range.lower[1]; y <= range.upper[1]; ++y)
        for (std::int64_t x = range.lower[0]; x <= range.upper[0]; ++x, ++at)
          if (marks[at])
            keys.push_back({std::int32_t(x), std::int32_t(y), std::int32_t(z)});
  }
};

} // namespace

BrickKeys collect_bricks(const mesh::AmrView& mesh, const core::Threads& threads) {
  const Ranges ranges = find_ranges(mesh, threads);
  const std::int64_t n = mesh.cell_count();
  std::array<Marks, depths> marks;
  bool sparse[depths] = {};
  bool any_sparse = false;
  for (std::size_t d = 0; d < depths; ++d) {
    if (ranges[d].cells == 0)
      continue;
    sparse[d] = ranges[d].volume() > 4096 + 4.0 * double(ranges[d].cells);
    any_sparse |= sparse[d];
    marks[d].range = ranges[d];
    if (!sparse[d])
      marks[d].marks.resize(std::size_t(ranges[d].volume()));
  }
  std::vector<BrickKeys> of_chunk(any_sparse ? std::size_t((n + grain - 1) / grain) : 0);
  threads.parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
    BrickKeys* keys = any_sparse ? &of_chunk[std::size_t(begin / grain)] : nullptr;
    for_runs(mesh, begin, end,
             [&](int depth, const std::int64_t* index, std::int64_t count, std::int64_t) {
               const std::size_t d = std::size_t(depth);
               for (std::int64_t x = index[0] >> 3; x <= (index[0] + count - 1) >> 3; ++x) {
                 if (!sparse[d]) {
                   marks[d].mark(x, index[1] >> 3, index[2] >> 3);
                   continue;
                 }
                 const BrickKey k = {std::int32_t(x), std::int32_t(index[1] >> 3),
                                     std::int32_t(index[2] >> 3)};
                 if ((*keys)[d].empty() || !((*keys)[d].back() == k))
                   (*keys)[d].push_back(k);
               }
             });
    for (std::size_t d = 0; keys && d < depths; ++d)
      normalize((*keys)[d]);
  });
  BrickKeys keys;
  for (std::size_t d = 0; d < depths; ++d) {
    if (ranges[d].cells == 0)
      continue;
    if (!sparse[d])
      marks[d].list(keys[d]);
    for (const BrickKeys& chunk : of_chunk)
      keys[d].insert(keys[d].end(), chunk[d].begin(), chunk[d].end());
    if (sparse[d])
      normalize(keys[d]);
  }
  add_bricks_above(keys);
  return keys;
}

void add_bricks_above(BrickKeys& keys) {
  for (std::size_t d = depths - 1; d > 0; --d) {
    if (keys[d].empty())
      continue;
    std::vector<BrickKey>& above = keys[d - 1];
    const std::size_t own = above.size();
    for (const BrickKey& k : keys[d])
      if (above.size() == own || !(above.back() == k.parent()))
        above.push_back(k.parent());
    normalize(above);
  }
}

} // namespace insitu::amr

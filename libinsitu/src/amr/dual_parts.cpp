#include "amr/dual_parts.h"

#include <algorithm>
#include <numeric>

#include "amr/balance.h"

namespace insitu::amr {

namespace {

constexpr std::int64_t bricks_a_part = 32;

std::int64_t part_count(std::int64_t bricks) {
  return (bricks + bricks_a_part - 1) / bricks_a_part;
}

/// Enumerates some bricks into parts, added at the end.
void add_parts(const BrickStore& store, const std::vector<std::uint32_t>& bricks, std::int64_t real,
               Check check, std::vector<DualPart>& parts, const core::Threads& threads) {
  const std::int64_t n = std::int64_t(bricks.size());
  DualPart* to = nullptr;
  parts.resize(parts.size() + std::size_t(part_count(n)));
  to = parts.data() + parts.size() - part_count(n);
  threads.parallel_for(n, bricks_a_part, [&](std::int64_t begin, std::int64_t end) {
    enumerate(store, {bricks.data() + begin, std::size_t(end - begin)}, real, check,
              to[begin / bricks_a_part]);
  });
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

/// Drops the parts that hold changed bricks; returns all bricks of these, as `split` numbers them,
/// and the ones that only it has.
std::vector<std::uint32_t> drop_changed(const BrickStore& store, const VirtualLeaves& made,
                                        const BrickStore& split, std::vector<DualPart>& parts) {
  const std::vector<char> changed = changed_bricks(store, made);
  std::vector<char> keep(std::size_t(split.brick_count()), 0);
  std::size_t kept = 0;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    const std::int64_t begin = std::int64_t(p) * bricks_a_part,
                       end = std::min(begin + bricks_a_part, store.brick_count());
    if (std::find(changed.begin() + begin, changed.begin() + end, 1) != changed.begin() + end)
      continue;
    for (std::int64_t b = begin; b < end; ++b)
      keep[split.find(store.depth_of(b), store.key(b))] = 1;
    if (kept != p)
      parts[kept] = std::move(parts[p]);
    ++kept;
  }
  parts.resize(kept);
  std::vector<std::uint32_t> again;
  for (std::size_t b = 0; b < keep.size(); ++b)
    if (!keep[b])
      again.push_back(std::uint32_t(b));
  return again;
}

} // namespace

DualParts make_dual_parts(const BrickStore& store, std::int64_t real, core::Memory& memory,
                          const core::Threads& threads) {
  DualParts dual;
  std::vector<std::uint32_t> bricks(std::size_t(store.brick_count()));
  std::iota(bricks.begin(), bricks.end(), 0u);
  add_parts(store, bricks, real, Check::steep, dual.parts, threads);
  bool steep = false;
  for (const DualPart& part : dual.parts) {
    steep |= !part.steep.empty();
    dual.folded += part.folded;
  }
  dual.made.first = real;
  if (!steep)
    return dual;
  dual.made = balance(store, dual.parts, real);
  BrickStore split(memory);
  overlay(store, dual.made, split, threads);
  bricks = drop_changed(store, dual.made, split, dual.parts);
  const std::size_t kept = dual.parts.size();
  add_parts(split, bricks, real, Check::split, dual.parts, threads);
  for (std::size_t p = kept; p < dual.parts.size(); ++p)
    dual.still_folded += dual.parts[p].folded;
  return dual;
}

} // namespace insitu::amr

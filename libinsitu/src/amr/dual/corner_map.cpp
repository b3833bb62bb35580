#include "amr/dual/corner_map.h"

#include <algorithm>
#include <atomic>
#include <cmath>

#include "amr/dual/enumerate.h"

namespace insitu::amr {

namespace {

/// Calls f(cell, part) for those of every part, at once for several parts.
template <class F>
void for_cells(const std::vector<DualPart>& parts, const core::Threads& threads, F&& f) {
  threads.parallel_for(std::int64_t(parts.size()), 1, [&](std::int64_t begin, std::int64_t end) {
    for (auto p = std::size_t(begin); p < std::size_t(end); ++p)
      for (const CornerCell& c : parts[p].at_corners)
        f(c, p);
  });
}

BrickKey key_of(const CornerCell& c) {
  return {c.corner[0] >> 3, c.corner[1] >> 3, c.corner[2] >> 3};
}
int layer_of(const CornerCell& c) {
  return c.corner[2] & 7;
}
std::uint64_t bit_of(const CornerCell& c) {
  return std::uint64_t(1) << ((c.corner[0] & 7) | (c.corner[1] & 7) << 3);
}

} // namespace

CornerKind CornerKind::of(const Corner& corner) {
  constexpr unsigned upper[3] = {0xaa, 0xcc, 0xf0}; // octants on the high side of an axis
  if (corner.most_up == 0) {
    constexpr std::uint32_t weight[3] = {1, 3, 9};
    std::uint32_t moves = 0;
    for (int a = 0; a < 3; ++a)
      moves += weight[a] * ((corner.inside & ~upper[a] & 0xff) == 0 ? 1
                            : (corner.inside & upper[a]) == 0       ? 2
                                                                    : 0);
    return box(moves);
  }
  if (corner.inside != 0xff || corner.most_up > most_up)
    return other();
  unsigned coarse = 0;
  for (int o = 0; o < 8; ++o) {
    if (corner.up[o] != 0 && corner.up[o] != corner.most_up)
      return other();
    coarse |= unsigned(corner.up[o] != 0) << o;
  }
  for (int a = 0; a < 3; ++a)
    for (const int side : {0, 1})
      if (coarse == (side ? upper[a] : ~upper[a] & 0xff))
        return frustum(a, side, corner.most_up);
  return other();
}

CornerMap::CornerMap(core::Memory& memory)
    : bricks_(memory, INSITU_MEMORY_AMR), cells_(memory, INSITU_MEMORY_AMR) {
  for (int d = 0; d <= mesh::Lattice::most_depth; ++d)
    tables_.emplace_back(memory);
}

void CornerMap::clear() {
  depth_count_ = 0;
  kinds_of_ = {};
  std::fill(farthest_, farthest_ + 3, 0.0);
  for (BrickTable& table : tables_)
    table.build({}, 0);
  bricks_.resize_discard(0);
  cells_.resize_discard(0);
}

void CornerMap::reach_as(const CornerMap& other) {
  for (std::size_t d = 0; d < kinds_of_.size(); ++d)
    kinds_of_[d] |= other.kinds_of_[d];
  for (int a = 0; a < 3; ++a)
    farthest_[a] = std::max(farthest_[a], other.farthest_[a]);
}

void CornerMap::share(parallel::World& world) {
  constexpr int kinds = 1 + CornerKind::most_up;
  std::array<std::int64_t, kinds*(mesh::Lattice::most_depth + 1)> has{};
  for (std::size_t i = 0; i < has.size(); ++i)
    has[i] = kinds_of_[i / kinds] >> (i % kinds) & 1;
  world.reduce(has, parallel::Reduction::greatest);
  for (std::size_t i = 0; i < has.size(); ++i)
    kinds_of_[i / kinds] = std::uint8_t(kinds_of_[i / kinds] | has[i] << (i % kinds));
  world.reduce(farthest_, parallel::Reduction::greatest);
}

std::int64_t CornerMap::bytes() const {
  std::int64_t sum = std::int64_t(bricks_.bytes() + cells_.bytes());
  for (const BrickTable& table : tables_)
    sum += table.bytes();
  return sum;
}

void CornerMap::build(const std::vector<DualPart>& parts,
                      const std::vector<std::int64_t>& first_cell, const core::Threads& threads) {
  clear();
  BrickKeys keys;
  std::size_t count = 0;
  for (const DualPart& part : parts) {
    count += part.at_corners.size();
    const CornerCell* last = nullptr;
    for (const CornerCell& c : part.at_corners) {
      if (!last || last->depth != c.depth || !(key_of(*last) == key_of(c)))
        keys[c.depth].push_back(key_of(c));
      kinds_of_[c.depth] |= std::uint8_t(1 << (c.kind.is_frustum() ? c.kind.up() : 0));
      last = &c;
    }
  }
  std::uint32_t brick_count = 0;
  for (std::size_t d = 0; d < keys.size(); ++d) {
    normalize(keys[d]);
    for (const BrickKey& k : keys[d]) {
      const std::int32_t lower[3] = {k.x, k.y, k.z};
      for (int a = 0; a < 3; ++a)
        farthest_[a] = std::max(farthest_[a], mesh::Lattice::power(int(d)) * 8.0 *
                                                  (std::fabs(double(lower[a])) + 1.0));
    }
    tables_[d].build(keys[d], brick_count);
    brick_count += std::uint32_t(keys[d].size());
    if (!keys[d].empty())
      depth_count_ = int(d) + 1;
  }
  bricks_.resize_discard(brick_count);
  std::fill(bricks_.begin(), bricks_.end(), Brick{});
  const auto brick_of = [&](const CornerCell& c) -> Brick& {
    return bricks_[tables_[c.depth].find(key_of(c))];
  };
  for_cells(parts, threads, [&](const CornerCell& c, std::size_t) {
    std::atomic_ref(brick_of(c).here[layer_of(c)]).fetch_or(bit_of(c), std::memory_order_relaxed);
  });
  std::uint32_t sum = 0;
  for (Brick& brick : bricks_) {
    brick.first = sum;
    std::uint32_t below = 0;
    for (int layer = 0; layer < 8; ++layer) {
      brick.below[layer] = std::uint16_t(below);
      below += core::count_bits(brick.here[layer]);
    }
    sum += below;
  }
  cells_.resize_discard(count);
  for_cells(parts, threads, [&](const CornerCell& c, std::size_t part) {
    const std::size_t at = rank(brick_of(c), layer_of(c), bit_of(c));
    const bool is_here = c.cell != CornerCell::not_here;
    cells_[at] = Entry({c.kind, is_here ? std::uint32_t(first_cell[part]) + c.cell : c.cell});
  });
}

} // namespace insitu::amr

#include "amr/leaves/neighborhood.h"

#include <algorithm>
#include <bit>
#include <cstring>

namespace insitu::amr {

namespace {

struct NoBrick {
  std::uint32_t entries[BrickStore::brick_entries];
  NoBrick() { std::fill_n(entries, BrickStore::brick_entries, BrickStore::nothing); }
};
const NoBrick no_brick;

/// Whether a finer leaf touches a corner from a place that is refined in part. If not, the place is
/// outside as the corner sees it.
bool finer_touches(const BrickStore& store, int depth, const std::int64_t* cell, int octant) {
  // Of a cell's children, the one at the corner lies on the side that the octant does not.
  const std::int64_t child[3] = {2 * cell[0] + (octant & 1 ? 0 : 1),
                                 2 * cell[1] + (octant & 2 ? 0 : 1),
                                 2 * cell[2] + (octant & 4 ? 0 : 1)};
  const std::uint32_t entry = store.at(depth + 1, child);
  return entry == BrickStore::refined_in_part ? finer_touches(store, depth + 1, child, octant)
                                              : entry != BrickStore::nothing;
}

} // namespace

bool corner_at(const BrickStore& store, int depth, const std::int64_t* index, Corner& corner) {
  corner.depth = depth;
  std::copy_n(index, 3, corner.index);
  corner.inside = 0;
  corner.most_up = 0;
  bool any = false;
  for (int o = 0; o < 8; ++o) {
    const std::int64_t cell[3] = {corner.cell(o, 0), corner.cell(o, 1), corner.cell(o, 2)};
    int up = 0;
    std::uint32_t id = store.at(depth, cell);
    if (id == BrickStore::refined ||
        (id == BrickStore::refined_in_part && finer_touches(store, depth, cell, o)))
      return false;
    any |= BrickStore::is_leaf(id);
    if (id == BrickStore::nothing)
      id = store.above(depth, cell, &up);
    corner.id[o] = id;
    corner.up[o] = 0;
    if (!BrickStore::is_leaf(id)) {
      corner.id[o] = BrickStore::nothing;
      continue;
    }
    corner.up[o] = std::uint8_t(up);
    corner.inside |= std::uint8_t(1 << o);
    corner.most_up = std::max(corner.most_up, up);
  }
  return any;
}

bool Neighborhood::load(const BrickStore& store, std::int64_t brick, std::int64_t real,
                        std::int64_t near) {
  const std::uint32_t* own = store.entries(brick);
  if (!std::any_of(own, own + BrickStore::brick_entries, BrickStore::is_leaf))
    return false;
  depth_ = store.depth_of(brick);
  const BrickKey key = store.key(brick);
  lower_[0] = std::int64_t(key.x) * 8 - 1;
  lower_[1] = std::int64_t(key.y) * 8 - 1;
  lower_[2] = std::int64_t(key.z) * 8 - 1;
  const std::uint32_t* around[27];
  for (int n = 0; n < 27; ++n) {
    const BrickKey k = {key.x + n % 3 - 1, key.y + n / 3 % 3 - 1, key.z + n / 9 - 1};
    const std::uint32_t b = n == 13 ? std::uint32_t(brick) : store.find(depth_, k);
    around[n] = b == BrickTable::none ? no_brick.entries : store.entries(b);
  }
  std::memset(up_, unknown, sizeof up_);
  for (int k = 0; k < side; ++k)
    for (int j = 0; j < side; ++j) {
      // Entry e of the ten lies in brick (e + 7) / 8 of three, at (e + 7) % 8.
      const std::uint32_t* const* bricks = around + 3 * ((j + 7) / 8) + 9 * ((k + 7) / 8);
      const int at = 8 * ((j + 7) & 7) + 64 * ((k + 7) & 7), row = j + side * k;
      std::uint32_t* to = entries_ + side * row;
      to[0] = bricks[0][at + 7];
      std::memcpy(to + 1, bricks[1] + at, 8 * sizeof *to);
      to[9] = bricks[2][at];
      unsigned leaf = 0, inside = 0, beside = 0, refined = 0;
      for (int i = 0; i < side; ++i) {
        leaf |= unsigned(BrickStore::is_leaf(to[i])) << i;
        inside |= unsigned(to[i] < real) << i;
        beside |= unsigned(to[i] < near) << i;
        refined |= unsigned(to[i] == BrickStore::refined) << i;
      }
      leaf_[row] = std::uint16_t(leaf);
      real_[row] = std::uint16_t(inside);
      near_[row] = std::uint16_t(beside);
      refined_[row] = std::uint16_t(refined);
    }
  return true;
}

unsigned Neighborhood::cubes(int j, int k) const {
  return row_all(real_, j, k) & row_any(near_, j, k);
}

unsigned Neighborhood::mixed(int j, int k) const {
  return row_any(leaf_, j, k) & ~row_any(refined_, j, k) & ~row_all(real_, j, k);
}

void Neighborhood::spread(int i, int j, int k) {
  const int from = i + side * (j + side * k);
  const auto begin = [](int e) { return std::max(((e + 1) & ~1) - 1, 0); };
  const auto end = [](int e) { return std::min(((e + 1) & ~1) + 1, side); };
  for (int z = begin(k); z < end(k); ++z)
    for (int y = begin(j); y < end(j); ++y)
      for (int x = begin(i); x < end(i); ++x) {
        entries_[x + side * (y + side * z)] = entries_[from];
        up_[x + side * (y + side * z)] = up_[from];
      }
}

bool Neighborhood::take(const BrickStore& store, int i, int j, int k, Corner& corner) {
  // A bit an octant: leaves of the depth.
  const int row = j + side * k;
  const unsigned own = (leaf_[row] >> i & 3u) | (leaf_[row + 1] >> i & 3u) << 2 |
                       (leaf_[row + side] >> i & 3u) << 4 | (leaf_[row + side + 1] >> i & 3u) << 6;
  const int first = std::countr_zero(own);
  const int at[3] = {i + (first & 1), j + (first >> 1 & 1), k + (first >> 2)};
  for (int a = 0; a < 3; ++a)
    if (at[a] < 1 || at[a] > 8)
      return false;

  corner.depth = depth_;
  corner.index[0] = lower_[0] + i + 1;
  corner.index[1] = lower_[1] + j + 1;
  corner.index[2] = lower_[2] + k + 1;
  const int lowest = i + side * row;
  for (int o = 0; o < 8; ++o) {
    corner.id[o] = entries_[lowest + offset(o)];
    corner.up[o] = 0;
  }
  corner.inside = std::uint8_t(own);
  corner.most_up = 0;
  for (unsigned others = ~own & 0xff; others != 0; others &= others - 1) {
    const int o = std::countr_zero(others);
    std::uint32_t& id = entries_[lowest + offset(o)];
    std::uint8_t& up = up_[lowest + offset(o)];
    if (id == BrickStore::refined_in_part || up == unknown) {
      const std::int64_t cell[3] = {corner.cell(o, 0), corner.cell(o, 1), corner.cell(o, 2)};
      if (id == BrickStore::refined_in_part) {
        if (finer_touches(store, depth_, cell, o))
          return false;
        corner.id[o] = BrickStore::nothing;
        continue;
      }
      int above = 0; // kept for the other corners of this place
      id = store.above(depth_, cell, &above);
      up = std::uint8_t(above);
      if (id != BrickStore::nothing)
        spread(i + (o & 1), j + (o >> 1 & 1), k + (o >> 2));
    }
    corner.id[o] = id;
    if (id == BrickStore::nothing)
      continue;
    corner.up[o] = up;
    corner.inside |= std::uint8_t(1 << o);
    corner.most_up = std::max(corner.most_up, int(up));
  }
  return true;
}

} // namespace insitu::amr

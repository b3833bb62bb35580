#pragma once

#include <cstdint>

#include "amr/leaves/brick_store.h"

namespace insitu::commit {

/// Calls f(id) for the leaves in a cell, which is refined, that lie at its sides: along each axis
/// at the lower (-1), the upper (1), or anywhere (0).
template <class F>
void for_leaves_at_side(const amr::BrickStore& store, const mesh::AmrCell& cell, const int* side,
                        F&& f) {
  for (int child = 0; child < 8; ++child) {
    mesh::AmrCell c{cell.depth + 1, {}};
    bool counts = true;
    for (int a = 0; a < 3; ++a) {
      const int upper = child >> a & 1;
      counts &= side[a] == 0 || side[a] == 2 * upper - 1;
      c.index[a] = 2 * cell.index[a] + upper;
    }
    const std::uint32_t entry = counts ? store.at(c.depth, c.index) : amr::BrickStore::nothing;
    if (amr::BrickStore::is_leaf(entry))
      f(entry);
    else if (entry != amr::BrickStore::nothing)
      for_leaves_at_side(store, c, side, f);
  }
}

/// Calls f(id) for the leaves that touch a cell by a face, an edge or a corner, some of them more
/// than once.
template <class F>
void for_touching(const amr::BrickStore& store, const mesh::AmrCell& cell, F&& f) {
  for (int n = 0; n < 27; ++n) {
    if (n == 13)
      continue;
    const int to[3] = {n % 3 - 1, n / 3 % 3 - 1, n / 9 - 1};
    mesh::AmrCell beside = cell;
    int side[3], up = 0;
    for (int a = 0; a < 3; ++a) {
      beside.index[a] += to[a];
      side[a] = -to[a];
    }
    std::uint32_t entry = store.at(cell.depth, beside.index);
    if (entry == amr::BrickStore::nothing)
      entry = store.above(cell.depth, beside.index, &up);
    if (amr::BrickStore::is_leaf(entry))
      f(entry);
    else if (entry != amr::BrickStore::nothing)
      for_leaves_at_side(store, beside, side, f);
  }
}

/// A leaf that shares a place with the cell; amr::BrickStore::nothing if there is none.
inline std::uint32_t overlapping_leaf(const amr::BrickStore& store, const mesh::AmrCell& cell) {
  int up = 0;
  std::uint32_t entry = store.at(cell.depth, cell.index);
  if (entry == amr::BrickStore::nothing)
    entry = store.above(cell.depth, cell.index, &up);
  if (entry == amr::BrickStore::nothing || amr::BrickStore::is_leaf(entry))
    return entry;
  const int anywhere[3] = {0, 0, 0};
  std::uint32_t found = amr::BrickStore::nothing;
  for_leaves_at_side(store, cell, anywhere, [&](std::uint32_t id) { found = std::min(found, id); });
  return found;
}

} // namespace insitu::commit

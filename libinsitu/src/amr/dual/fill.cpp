#include "amr/dual/fill.h"

#include <atomic>
#include <string>

#include "amr/dual/cell_runs.h"
#include "core/status.h"

namespace insitu::amr {

namespace {

std::string name_place(const mesh::AmrView& mesh, const mesh::AmrCell& c) {
  int level = 0;
  while (level + 1 < mesh.level_count && mesh.depth_of[level] != c.depth)
    ++level;
  if (mesh.finest_first)
    level = mesh.level_count - 1 - level;
  return "(" + std::to_string(c.index[0]) + ", " + std::to_string(c.index[1]) + ", " +
         std::to_string(c.index[2]) + ") of level " + std::to_string(level);
}

std::string name_cell(const mesh::AmrView& mesh, std::int64_t flat) {
  const std::int32_t p = piece_of(mesh, flat);
  const mesh::AmrPieceView& piece = mesh.pieces[p];
  const std::string cell = "cell " + std::to_string(flat - mesh.first_cell[p]) + " of piece ";
  return piece.rank < 0
             ? cell + std::to_string(p)
             : cell + std::to_string(piece.number) + " of process " + std::to_string(piece.rank);
}

/// Finds the bricks of cells that come one after the other.
class BrickFinder {
public:
  explicit BrickFinder(BrickStore& store) : store_(store) {}
  std::uint32_t* entries(int depth, const std::int64_t* index) {
    const BrickKey key = BrickStore::key_of(index);
    Last& last = last_[std::size_t(depth)];
    if (!last.entries || !(last.key == key))
      last = {key, store_.entries(store_.find(depth, key))};
    return last.entries;
  }

private:
  struct Last {
    BrickKey key;
    std::uint32_t* entries = nullptr;
  };
  BrickStore& store_;
  Last last_[mesh::Lattice::most_depth + 1];
};

/// Calls f(entry, flat) for every cell's entry.
template <class F>
void for_entries(BrickStore& store, const mesh::AmrView& mesh, std::int64_t begin, std::int64_t end,
                 F&& f) {
  BrickFinder finder(store);
  for_runs(mesh, begin, end,
           [&](int depth, const std::int64_t* index, std::int64_t count, std::int64_t first) {
             std::int64_t at[3] = {index[0], index[1], index[2]};
             while (count > 0) {
               std::uint32_t* entry = finder.entries(depth, at) + BrickStore::entry_of(at);
               const std::int64_t part = std::min(count, 8 - (at[0] & 7));
               for (std::int64_t i = 0; i < part; ++i)
                 f(entry[i], first + i);
               count -= part;
               first += part;
               at[0] += part;
             }
           });
}

/// Fills once more, in order, to name the same two cells whatever the threads did.
[[noreturn]] void throw_overlap(BrickStore& store, const mesh::AmrView& mesh) {
  for (std::int64_t b = 0; b < store.brick_count(); ++b)
    std::fill_n(store.entries(b), BrickStore::brick_entries, BrickStore::nothing);
  std::int64_t count = 0, first = -1, second = -1;
  for_entries(store, mesh, 0, mesh.cell_count(), [&](std::uint32_t& entry, std::int64_t flat) {
    if (entry == BrickStore::nothing) {
      entry = std::uint32_t(flat);
      return;
    }
    if (count++ == 0) {
      first = entry;
      second = flat;
    }
  });
  throw core::Error(INSITU_ERROR_MESH,
                    "cells overlap: " + name_cell(mesh, first) + " and " + name_cell(mesh, second) +
                        " are both " + name_place(mesh, cell_at(mesh, first)) + "; " +
                        std::to_string(count) + (count == 1 ? " cell lies" : " cells lie") +
                        " on another in all");
}

/// How a place of a depth is covered by the eight of the next, or by the first four of them.
enum class Cover { none, in_part, full };

Cover cover_of(const std::uint32_t* fine, int count) {
  int covered = 0;
  bool any = false;
  for (int o = 0; o < count; ++o) {
    const std::uint32_t e = fine[(o & 1) | (o & 2) << 2 | (o & 4) << 4];
    covered += BrickStore::is_leaf(e) || e == BrickStore::refined;
    any |= e != BrickStore::nothing;
  }
  return covered == count ? Cover::full : any ? Cover::in_part : Cover::none;
}

void keep_least(std::atomic<std::int64_t>& least, std::int64_t value) {
  std::int64_t now = least.load(std::memory_order_relaxed);
  while (value < now && !least.compare_exchange_weak(now, value, std::memory_order_relaxed)) {
  }
}

} // namespace

void fill(BrickStore& store, const mesh::AmrView& mesh, const core::Threads& threads) {
  std::atomic<bool> overlap{false};
  threads.parallel_for(mesh.cell_count(), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
    bool clash = false;
    for_entries(store, mesh, begin, end, [&](std::uint32_t& entry, std::int64_t flat) {
      const auto id = mesh.is_covered(flat) ? BrickStore::refined : std::uint32_t(flat);
      clash |=
          std::atomic_ref(entry).exchange(id, std::memory_order_relaxed) != BrickStore::nothing;
    });
    if (clash)
      overlap.store(true, std::memory_order_relaxed);
  });
  if (overlap)
    throw_overlap(store, mesh);
}

std::int64_t mark_refined(BrickStore& store, const mesh::AmrView& mesh,
                          const core::Threads& threads) {
  std::atomic<std::int64_t> masked{0}, least{INT64_MAX};
  const std::int64_t own = mesh.own_cell_count();
  const int children = mesh.lattice.is_flat != 0 ? 4 : 8;
  for (std::int64_t flat = 0; mesh.covered && flat < own; ++flat)
    masked += mesh.is_covered(flat);
  for (int d = store.depth_count() - 1; d > 0; --d) {
    const std::int64_t first = store.first_brick(d);
    // A brick covers an eighth of the one above it: no two write the same entries.
    threads.parallel_for(
        store.first_brick(d + 1) - first, 32, [&](std::int64_t begin, std::int64_t end) {
          std::int64_t covered = 0;
          for (std::int64_t b = first + begin; b < first + end; ++b) {
            const BrickKey& key = store.key(b);
            const std::uint32_t* fine = store.entries(b);
            std::uint32_t* coarse = store.entries(store.find(d - 1, key.parent())) +
                                    4 * ((key.x & 1) + 8 * (key.y & 1) + 64 * (key.z & 1));
            for (int n = 0; n < 64; ++n) {
              const int i = n & 3, j = n >> 2 & 3, k = n >> 4;
              const Cover cover = cover_of(fine + 2 * (i + 8 * j + 64 * k), children);
              if (cover == Cover::none)
                continue;
              std::uint32_t& entry = coarse[i + 8 * j + 64 * k];
              if (entry == BrickStore::nothing) {
                entry = cover == Cover::full ? BrickStore::refined : BrickStore::refined_in_part;
                continue;
              }
              if (entry == BrickStore::refined) // counted already
                continue;
              // What covers another process's cell is known there, or what covers the rest.
              if (cover == Cover::in_part && entry < own && !mesh.is_part)
                keep_least(least, entry);
              entry = BrickStore::refined;
              ++covered;
            }
          }
          masked += covered;
        });
  }
  if (least != INT64_MAX)
    throw core::Error(INSITU_ERROR_MESH,
                      name_cell(mesh, least) + ", " + name_place(mesh, cell_at(mesh, least)) +
                          ", is covered by finer cells in part only: boxes have to begin and end "
                          "at faces of the level above");
  return masked;
}

} // namespace insitu::amr

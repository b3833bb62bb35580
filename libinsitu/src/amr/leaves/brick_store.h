#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/adaptive.h"

namespace insitu::amr {

/// Which of a depth's bricks: its cells' indices without their last three bits.
struct BrickKey {
  std::int32_t x, y, z;
  bool operator==(const BrickKey&) const = default;
  bool operator<(const BrickKey& b) const {
    return z != b.z ? z < b.z : y != b.y ? y < b.y : x < b.x;
  }
  BrickKey parent() const { return {x >> 1, y >> 1, z >> 1}; }
};

/// The bricks of every depth, each sorted and unique.
using BrickKeys = std::array<std::vector<BrickKey>, mesh::Lattice::most_depth + 1>;

/// Sorts and makes unique.
void normalize(std::vector<BrickKey>& keys);

/// From a key to a brick's number: an array over the keys' bounding range while that is not much
/// larger than the bricks, else an open-addressing hash table.
class BrickTable {
public:
  static constexpr std::uint32_t none = 0xffffffff;

  explicit BrickTable(core::Memory& memory);
  /// Numbers the keys from `first` on.
  void build(const std::vector<BrickKey>& keys, std::uint32_t first);
  std::int64_t bytes() const { return std::int64_t(dense_.bytes() + slots_.bytes()); }

  std::uint32_t find(const BrickKey& k) const {
    if (slots_.empty()) {
      const std::uint32_t x = std::uint32_t(k.x) - std::uint32_t(lower_.x),
                          y = std::uint32_t(k.y) - std::uint32_t(lower_.y),
                          z = std::uint32_t(k.z) - std::uint32_t(lower_.z);
      return x < size_[0] && y < size_[1] && z < size_[2]
                 ? dense_[x + std::size_t(size_[0]) * (y + std::size_t(size_[1]) * z)]
                 : none;
    }
    for (std::size_t s = hash(k) & mask_;; s = (s + 1) & mask_)
      if (slots_[s].brick == none || slots_[s].key == k)
        return slots_[s].brick;
  }

  /// Calls f(key, brick) for all, in any order.
  template <class F>
  void for_each(F&& f) const {
    for (const Slot& slot : slots_)
      if (slot.brick != none)
        f(slot.key, slot.brick);
    std::size_t at = 0;
    for (std::uint32_t z = 0; slots_.empty() && z < size_[2]; ++z)
      for (std::uint32_t y = 0; y < size_[1]; ++y)
        for (std::uint32_t x = 0; x < size_[0]; ++x, ++at)
          if (dense_[at] != none)
            f(BrickKey{std::int32_t(std::uint32_t(lower_.x) + x),
                       std::int32_t(std::uint32_t(lower_.y) + y),
                       std::int32_t(std::uint32_t(lower_.z) + z)},
              dense_[at]);
  }

private:
  struct Slot {
    BrickKey key;
    std::uint32_t brick;
  };
  static std::size_t hash(const BrickKey& k) {
    std::uint64_t h = std::uint32_t(k.x) * 0x9e3779b97f4a7c15ull;
    h = (h ^ (h >> 32) ^ std::uint32_t(k.y)) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ (h >> 32) ^ std::uint32_t(k.z)) * 0x94d049bb133111ebull;
    return std::size_t(h ^ (h >> 29));
  }

  BrickKey lower_ = {0, 0, 0};
  std::uint32_t size_[3] = {0, 0, 0};
  std::size_t mask_ = 0;
  core::Buffer<std::uint32_t> dense_;
  core::Buffer<Slot> slots_;
};

/// Bricks of 8x8x8 entries, one a cell of a depth's lattice: the id of the leaf there, or what is
/// there instead. Bricks are numbered over the depths, in the order of their keys.
class BrickStore {
public:
  static constexpr std::uint32_t nothing = 0xffffffff; ///< outside, or in a coarser leaf
  static constexpr std::uint32_t refined = 0xfffffffe; ///< finer cells lie here
  /// Finer cells lie here, but not everywhere: no cell of this depth or a coarser one is here.
  static constexpr std::uint32_t refined_in_part = 0xfffffffd;
  static constexpr std::uint32_t most_leaves = 0xfffffffd;
  static constexpr int side = 8, brick_entries = 512;

  static bool is_leaf(std::uint32_t entry) { return entry < refined_in_part; }
  static BrickKey key_of(const std::int64_t* index) {
    return {std::int32_t(index[0] >> 3), std::int32_t(index[1] >> 3), std::int32_t(index[2] >> 3)};
  }
  static int entry_of(const std::int64_t* index) {
    return int((index[0] & 7) | (index[1] & 7) << 3 | (index[2] & 7) << 6);
  }

  explicit BrickStore(core::Memory& memory);
  /// Makes the bricks, with nothing in them.
  void create(const BrickKeys& keys, const core::Threads& threads);

  int depth_count() const { return depth_count_; }
  std::int64_t brick_count() const { return first_[std::size_t(depth_count_)]; }
  /// The first brick of a depth; of depth_count(): all bricks.
  std::int64_t first_brick(int depth) const { return first_[std::size_t(depth)]; }
  int depth_of(std::int64_t brick) const {
    int d = 0;
    while (brick >= first_[std::size_t(d + 1)])
      ++d;
    return d;
  }
  const BrickKey& key(std::int64_t brick) const { return keys_[std::size_t(brick)]; }
  std::uint32_t* entries(std::int64_t brick) { return entries_.data() + brick * brick_entries; }
  const std::uint32_t* entries(std::int64_t brick) const {
    return entries_.data() + brick * brick_entries;
  }
  std::uint32_t find(int depth, const BrickKey& key) const {
    return tables_[std::size_t(depth)].find(key);
  }
  std::int64_t bytes() const;

  std::uint32_t at(int depth, const std::int64_t* index) const {
    if (depth >= depth_count_)
      return nothing;
    const std::uint32_t brick = find(depth, key_of(index));
    return brick == BrickTable::none
               ? nothing
               : entries_[std::size_t(brick) * brick_entries + std::size_t(entry_of(index))];
  }

  /// What covers a place where nothing is at its depth: the id of a coarser leaf and how many
  /// depths above it lies; nothing outside.
  std::uint32_t above(int depth, const std::int64_t* index, int* up) const {
    for (int u = 1; u <= depth; ++u) {
      const std::int64_t coarse[3] = {index[0] >> u, index[1] >> u, index[2] >> u};
      const std::uint32_t entry = at(depth - u, coarse);
      if (entry != nothing) {
        *up = u;
        return is_leaf(entry) ? entry : nothing;
      }
    }
    return nothing;
  }

private:
  int depth_count_ = 0;
  std::array<std::int64_t, mesh::Lattice::most_depth + 2> first_{};
  std::vector<BrickTable> tables_;
  core::Buffer<BrickKey> keys_;
  core::Buffer<std::uint32_t> entries_;
};

} // namespace insitu::amr

#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <vector>

#include "amr/leaves/brick_store.h"
#include "amr/leaves/neighborhood.h"
#include "core/count_bits.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "parallel/world.h"

namespace insitu::amr {

struct DualPart;

/// What the stitching cell at a corner is, a byte:
///
/// - a frustum: between four leaves of the corner's depth and those of one or two depths above,
///   across one axis; where these are fewer than four, a wedge or a pyramid. Sections across the
///   axis are rectangles along the others;
/// - a box: among leaves of one depth, virtual ones, or halved along some axes where the domain
///   ends;
/// - another cell.
struct CornerKind {
  std::uint8_t code = 0;

  /// side: 1 if the coarser leaves lie on the high side of the axis; up: depths, 1 or 2.
  static CornerKind frustum(int axis, int side, int up) {
    return {std::uint8_t(1 + axis + 4 * side + 8 * (up - 1))};
  }
  /// moves: as VertexKey's; along an axis, 1: the domain ends at the corner, and the cell lies
  /// above it; 2: below it; 0: neither.
  static CornerKind box(std::uint32_t moves) { return {std::uint8_t(first_box + moves)}; }
  static CornerKind other() { return {first_other}; }
  /// Of the cell at a corner.
  static CornerKind of(const Corner& corner);

  explicit operator bool() const { return code != 0; }
  bool is_frustum() const { return code != 0 && code < first_box; }
  bool is_box() const { return code >= first_box && code < first_other; }
  int axis() const { return (code - 1) & 3; }
  int side() const { return (code - 1) >> 2 & 1; }
  int up() const { return ((code - 1) >> 3) + 1; }
  std::uint32_t moves() const { return std::uint32_t(code - first_box); }
  bool operator==(const CornerKind&) const = default;

  static constexpr int most_up = 2;
  static constexpr std::uint8_t first_box = 1 + 8 * most_up, first_other = first_box + 27;
};

/// The stitching cell at a corner of its depth's lattice; see Corner. Its kind is told of corners
/// around this process's cells, too, at which others have cells: points take the same way to their
/// cells, and have the same coordinates there, on all processes.
struct CornerCell {
  static constexpr std::uint32_t not_here = UINT32_MAX;

  std::int32_t corner[3];
  std::uint8_t depth;
  CornerKind kind;
  std::uint32_t cell; ///< of its part's stitching cells, or not_here
};

/// Which stitching cell stands at a corner: a bit a corner, in bricks of 8x8x8, and a cell a bit.
/// Those that fill re-entrant corners are left out.
class CornerMap {
public:
  explicit CornerMap(core::Memory& memory);

  /// first_cell: of each part's stitching cells.
  void build(const std::vector<DualPart>& parts, const std::vector<std::int64_t>& first_cell,
             const core::Threads& threads);
  void clear();
  std::int64_t bytes() const;

  /// Depths that have some: [0, depth_count()).
  int depth_count() const { return depth_count_; }
  /// No corner is farther from the lattice's origin along an axis, in cells of depth 0.
  double farthest(int axis) const { return farthest_[axis]; }
  /// What is told of all cells is that of the other map's, too.
  void reach_as(const CornerMap& other);
  /// Collective: what is told of all cells becomes that of all processes, so that points take the
  /// same way to their cells, and have the same coordinates there, on all of them.
  void share(parallel::World& world);
  /// Whether there are frusta of a depth beside leaves `up` depths above.
  bool has_frusta(int depth, int up) const {
    return (kinds_of_[std::size_t(depth)] >> up & 1) != 0;
  }

  struct Found {
    CornerKind kind;
    std::uint32_t cell = 0; ///< a stitching cell, or CornerCell::not_here
    explicit operator bool() const { return bool(kind); }
    bool is_here() const { return cell != CornerCell::not_here; }
  };
  Found find(int depth, const std::int64_t* corner) const {
    const std::uint32_t b = tables_[std::size_t(depth)].find(BrickStore::key_of(corner));
    if (b == BrickTable::none)
      return {};
    const Brick& brick = bricks_[b];
    const int word = int(corner[2] & 7);
    const std::uint64_t bit = std::uint64_t(1) << ((corner[0] & 7) | (corner[1] & 7) << 3);
    if ((brick.here[word] & bit) == 0)
      return {};
    const std::size_t at = rank(brick, word, bit);
    return cells_[at].found();
  }

  /// Calls f(depth, corner, found) for all, in any order.
  template <class F>
  void for_each(F&& f) const {
    for (int depth = 0; depth < depth_count_; ++depth)
      tables_[std::size_t(depth)].for_each([&](const BrickKey& key, std::uint32_t b) {
        for (int e = 0; e < BrickStore::brick_entries; ++e) {
          const std::int64_t corner[3] = {std::int64_t(key.x) * 8 + (e & 7),
                                          std::int64_t(key.y) * 8 + (e >> 3 & 7),
                                          std::int64_t(key.z) * 8 + (e >> 6)};
          if ((bricks_[b].here[e >> 6] >> (e & 63) & 1) != 0)
            f(depth, corner, find(depth, corner));
        }
      });
  }

private:
  /// Found, in five bytes side by side: mostly one line of the cache.
  class Entry {
  public:
    Entry() = default;
    explicit Entry(const Found& f) : kind_(f.kind) { std::memcpy(cell_, &f.cell, sizeof f.cell); }
    Found found() const {
      Found f = {kind_};
      std::memcpy(&f.cell, cell_, sizeof f.cell);
      return f;
    }

  private:
    CornerKind kind_;
    std::uint8_t cell_[sizeof(std::uint32_t)] = {};
  };
  struct Brick {
    std::uint64_t here[8];  ///< a word a layer, a bit a corner
    std::uint32_t first;    ///< of the cells here
    std::uint16_t below[8]; ///< cells before a layer
  };
  static std::size_t rank(const Brick& brick, int word, std::uint64_t bit) {
    return std::size_t(brick.first) + brick.below[word] +
           core::count_bits(brick.here[word] & (bit - 1));
  }

  int depth_count_ = 0;
  std::array<std::uint8_t, mesh::Lattice::most_depth + 1> kinds_of_{}; ///< bit 0: others
  double farthest_[3] = {0, 0, 0};
  std::vector<BrickTable> tables_;
  core::Buffer<Brick> bricks_;
  core::Buffer<Entry> cells_;
};

} // namespace insitu::amr

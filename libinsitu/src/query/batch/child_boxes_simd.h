// The child boxes of a node beside queries, once per Highway target. Include after
// hwy/foreach_target.h, like any per-target header of Highway.
#if defined(INSITU_QUERY_CHILD_BOXES_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INSITU_QUERY_CHILD_BOXES_SIMD_H
#undef INSITU_QUERY_CHILD_BOXES_SIMD_H
#else
#define INSITU_QUERY_CHILD_BOXES_SIMD_H
#endif

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <hwy/highway.h>

#include "accel/tree/node.h"
#include "query/batch/bit_tables.h"
#include "query/batch/candidates.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET != HWY_SCALAR

/// A node's child boxes, decoded once for all queries at the node. A child has two lanes side by
/// side, for its lower and its upper face, and so has a query (QueryBoxes): a product and a sum an
/// axis tell how far the query reaches beyond both.
class ChildBoxes {
public:
  /// In steps of the node's grid; see Node::depth.
  HWY_INLINE void decode(const accel::Node& node) {
    const hn::FixedTag<std::uint8_t, 8> d_half;
    const hn::FixedTag<std::uint8_t, 16> d_bytes;
    const hn::Rebind<std::int32_t, Floats> d_ints;
    const hn::Rebind<std::uint8_t, Floats> d_some;
    const auto sign = hn::OddEven(hn::Set(d, 1.0f), hn::Set(d, -1.0f));
    for (int a = 0; a < 3; ++a) {
      const float inverse = accel::inverse_scale(node.exponent[a]);
      const auto lower = hn::ZeroExtendVector(d_bytes, hn::LoadU(d_half, node.child_lower[a]));
      const auto upper = hn::ZeroExtendVector(d_bytes, hn::LoadU(d_half, node.child_upper[a]));
      alignas(16) std::uint8_t bytes[16];
      hn::Store(hn::InterleaveLower(d_bytes, lower, upper), d_bytes, bytes);
      const auto corner = hn::Mul(sign, hn::Set(d, node.lower[a] * inverse));
      steps_a_unit_[a] = hn::Set(d, inverse);
      for (int i = 0; i < parts; ++i) {
        const auto step =
            hn::ConvertTo(d, hn::PromoteTo(d_ints, hn::LoadU(d_some, bytes + i * lanes)));
        const auto face = hn::MulAdd(sign, step, corner);
        face_[a][i] = hn::Add(face, hn::Set(d, accel::depth_slack));
      }
    }
  }

  /// Bit c: the query's box meets child c's.
  HWY_INLINE unsigned overlapping(const float* bounds) const {
    unsigned bits = 0;
    for (int i = 0; i < parts; ++i)
      bits |= met(reach(bounds, i)) << (i * pairs);
    return bits;
  }

  /// For append(): which children are leaves, by bits; child c's slot is first + offsets[c].
  HWY_INLINE void set_leaves(unsigned leaves, std::uint32_t first, const std::uint8_t* offsets) {
    leaves_ = leaves;
    for (int i = 0; i < parts; ++i) {
      const auto offset = hn::PromoteTo(d_slots, hn::LoadU(d_offsets, offsets + i * pairs));
      slot_[i] = hn::PromoteTo(d_pairs, hn::Add(offset, hn::Set(d_slots, first)));
    }
  }

  /// The candidates of leaf children that the query's box meets, in order; and the bits of
  /// overlapping(). Returns how many. Eight at `out` may be written whatever they are: branches on
  /// that would be guessed wrongly too often.
  HWY_INLINE std::size_t append(const float* bounds, QueryId query, Candidate* out,
                                unsigned& overlaps) const {
    static_assert(sizeof(Candidate) == 8 && offsetof(Candidate, query) == 4 &&
                  offsetof(Candidate, depth) == 6);
    const auto whole_steps = hn::Set(d, accel::whole_steps), most = hn::Set(d, 255.0f);
    const auto item = hn::Set(d_pairs, std::uint64_t(query) << 32);
    std::size_t found = 0;
    overlaps = 0;
    for (int i = 0; i < parts; ++i) {
      const auto far = reach(bounds, i);
      const unsigned bits = met(far);
      overlaps |= bits << (i * pairs);
      const auto steps = hn::Add(hn::Min(hn::Max(far, hn::Zero(d)), most), whole_steps);
      const auto depth = hn::And(hn::BitCast(d_pairs, steps), hn::Set(d_pairs, 255u));
      const auto candidates = hn::Or(hn::Or(slot_[i], item), hn::ShiftLeft<48>(depth));
      const unsigned taken = bits & (leaves_ >> (i * pairs));
      hn::StoreU(chosen(candidates, taken), d_pairs, reinterpret_cast<std::uint64_t*>(out + found));
      found += std::size_t(std::popcount(taken));
    }
    return found;
  }

private:
  using Floats = hn::CappedTag<float, 16>;
  using Pairs = hn::Repartition<std::uint64_t, Floats>;
  static constexpr Floats d{};
  static constexpr Pairs d_pairs{};
  static constexpr hn::Rebind<std::uint32_t, Pairs> d_slots{};
  static constexpr hn::Rebind<std::uint8_t, Pairs> d_offsets{};
  static constexpr int lanes = int(hn::MaxLanes(Floats())), pairs = lanes / 2, parts = 16 / lanes;

  /// Of the query and each child, the least way that it reaches beyond a face, in both lanes.
  HWY_INLINE hn::Vec<Floats> reach(const float* bounds, int part) const {
    const auto axis = [&](int a) HWY_ATTR {
      std::uint64_t both;
      std::memcpy(&both, bounds + 2 * a, sizeof both);
      const auto query = hn::BitCast(d, hn::Set(d_pairs, both));
      return hn::MulAdd(query, steps_a_unit_[a], face_[a][part]);
    };
    const auto least = hn::Min(axis(0), hn::Min(axis(1), axis(2)));
    return hn::Min(least, hn::Shuffle2301(least));
  }
  /// By bits, which do not reach beyond a face. (None is minus zero: the slack sees to that.)
  static HWY_INLINE unsigned met(hn::Vec<Floats> reach) {
    const hn::Repartition<std::int64_t, Floats> d_signed;
    std::uint8_t byte[8] = {};
    hn::StoreMaskBits(
        d_signed, hn::Gt(hn::BitCast(d_signed, reach), hn::Set(d_signed, std::int64_t(-1))), byte);
    return byte[0];
  }
  /// Those of set bits, side by side. (Highway 1.0.3's Compress of 64-bit lanes copies its table to
  /// the stack each time.)
  static HWY_INLINE hn::Vec<Pairs> chosen(hn::Vec<Pairs> items, unsigned bits) {
    const auto places = hn::PromoteTo(d_slots, hn::LoadU(d_offsets, set_bits[bits].data()));
    return hn::TableLookupLanes(items, hn::IndicesFromVec(d_pairs, hn::PromoteTo(d_pairs, places)));
  }

  hn::Vec<Floats> face_[3][parts], steps_a_unit_[3];
  hn::Vec<Pairs> slot_[parts];
  unsigned leaves_ = 0;
};

#else

/// The same, child by child.
class ChildBoxes {
public:
  void decode(const accel::Node& node) {
    node_ = &node;
    for (int c = 0; c < 8; ++c)
      box_[c] = node.child_box(c);
  }
  unsigned overlapping(const float* bounds) const {
    unsigned bits = 0;
    for (unsigned c = 0; c < 8; ++c) {
      bool meet = true;
      for (int a = 0; a < 3; ++a)
        meet &= box_[c].lower[a] <= bounds[2 * a] && -box_[c].upper[a] <= bounds[2 * a + 1];
      bits |= unsigned(meet) << c;
    }
    return bits;
  }
  void set_leaves(unsigned leaves, std::uint32_t first, const std::uint8_t* offsets) {
    leaves_ = leaves;
    first_ = first;
    offsets_ = offsets;
  }
  std::size_t append(const float* bounds, QueryId query, Candidate* out, unsigned& overlaps) const {
    overlaps = overlapping(bounds);
    const float lower[3] = {-bounds[1], -bounds[3], -bounds[5]};
    const float upper[3] = {bounds[0], bounds[2], bounds[4]};
    std::size_t found = 0;
    for (unsigned rest = overlaps & leaves_; rest; rest &= rest - 1) {
      const int c = std::countr_zero(rest);
      out[found++] = {first_ + offsets_[c], query, node_->depth(c, lower, upper), 0};
    }
    return found;
  }

private:
  const accel::Node* node_ = nullptr;
  accel::Box box_[8];
  unsigned leaves_ = 0;
  std::uint32_t first_ = 0;
  const std::uint8_t* offsets_ = nullptr;
};

#endif

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

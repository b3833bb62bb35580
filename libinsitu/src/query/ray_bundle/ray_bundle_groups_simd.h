// Which groups of a bundle's rays have samples near a box, once per Highway target. Include after
// hwy/foreach_target.h, like any per-target header of Highway.
#if defined(INSITU_QUERY_RAY_BUNDLE_GROUPS_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INSITU_QUERY_RAY_BUNDLE_GROUPS_SIMD_H
#undef INSITU_QUERY_RAY_BUNDLE_GROUPS_SIMD_H
#else
#define INSITU_QUERY_RAY_BUNDLE_GROUPS_SIMD_H
#endif

#include <cstddef>
#include <hwy/highway.h>

#include "query/batch/bit_tables.h"
#include "query/ray_bundle/ray_bundle_kernels.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::CappedTag<float, bundle_lanes>;
using FloatVec = hn::Vec<Floats>;

/// Puts the lanes of a mask side by side; what follows them says nothing.
class Packer {
public:
  using Ints = hn::Rebind<std::int32_t, Floats>;
  HWY_INLINE explicit Packer(const hn::Mask<Floats>& mask) : mask_(mask) {
#if HWY_TARGET == HWY_AVX2 // Highway 1.0 copies a row of its table by a string instruction
    std::uint8_t bits[8] = {};
    hn::StoreMaskBits(Floats(), mask, bits);
    const hn::Rebind<std::uint8_t, Floats> bytes;
    order_ = hn::BitCast(Ints(), hn::PromoteTo(hn::RebindToUnsigned<Floats>(),
                                               hn::LoadU(bytes, set_bits[bits[0]].data())));
#endif
  }
  HWY_INLINE void store(const FloatVec& v, float* to) const {
    const Floats d;
#if HWY_TARGET == HWY_AVX2
    hn::StoreU(hn::TableLookupLanes(v, hn::IndicesFromVec(d, order_)), d, to);
#else
    hn::StoreU(hn::Compress(v, mask_), d, to);
#endif
  }
  HWY_INLINE void store(const hn::Vec<Ints>& v, std::int32_t* to) const {
    const Ints d;
#if HWY_TARGET == HWY_AVX2
    hn::StoreU(hn::TableLookupLanes(v, hn::IndicesFromVec(d, order_)), d, to);
#else
    hn::StoreU(hn::Compress(v, hn::RebindMask(d, mask_)), d, to);
#endif
  }

private:
  hn::Mask<Floats> mask_;
#if HWY_TARGET == HWY_AVX2
  hn::Vec<Ints> order_;
#endif
};

/// Of some groups.
struct GroupSamples {
  hn::Mask<Floats> any; ///< there may be samples within the extent
  FloatVec first, last; ///< where they are: none outside of these, whole numbers
};

/// Of groups g to g + lanes - 1. lower_of[a][i], upper_of[a][i]: an extent along the slab's axis a,
/// rounded outwards as the samples may be.
template <std::size_t n>
HWY_INLINE GroupSamples samples_of_groups(const BundleSlab& slab, std::size_t g,
                                          const float (&lower_of)[3][n],
                                          const float (&upper_of)[3][n], int i) {
  const Floats d;
  const auto lower = [&](int a) HWY_ATTR { return hn::Set(d, lower_of[a][i]); };
  const auto upper = [&](int a) HWY_ATTR { return hn::Set(d, upper_of[a][i]); };
  auto any = hn::And(hn::Le(lower(0), hn::Load(d, slab.group_upper[0] + g)),
                     hn::Ge(upper(0), hn::Load(d, slab.group_lower[0] + g)));
  any = hn::And(any, hn::Le(lower(1), hn::Load(d, slab.group_upper[1] + g)));
  any = hn::And(any, hn::Ge(upper(1), hn::Load(d, slab.group_lower[1] + g)));
  const auto rounding = hn::Load(d, slab.index_rounding + g);
  const auto from = hn::NegMulSub(hn::Sub(hn::Load(d, slab.last_w + g), lower(2)),
                                  hn::Load(d, slab.first_per_w + g), rounding);
  const auto to = hn::MulAdd(hn::Sub(upper(2), hn::Load(d, slab.first_w + g)),
                             hn::Load(d, slab.last_per_w + g), rounding);
  const auto first = hn::Ceil(hn::Max(from, hn::Zero(d)));
  const auto last = hn::Floor(hn::Min(to, hn::Set(d, float(slab.depth - 1))));
  return {hn::And(any, hn::Le(first, last)), first, last};
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

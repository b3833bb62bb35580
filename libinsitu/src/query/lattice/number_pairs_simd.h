// Numbers that lie side by side, a pair a lane, once per Highway target. Include after
// hwy/foreach_target.h, like any per-target header of Highway.
#if defined(INSITU_QUERY_NUMBER_PAIRS_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INSITU_QUERY_NUMBER_PAIRS_SIMD_H
#undef INSITU_QUERY_NUMBER_PAIRS_SIMD_H
#else
#define INSITU_QUERY_NUMBER_PAIRS_SIMD_H
#endif

#include <cstdint>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace insitu::query::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

#if HWY_TARGET != HWY_SCALAR
using PairTag = hn::FixedTag<double, 2>;

HWY_INLINE hn::Vec<PairTag> pair_at(const double* from) {
  return hn::LoadU(PairTag(), from);
}
HWY_INLINE hn::Vec<PairTag> pair_at(const float* from) {
  return hn::PromoteTo(PairTag(), hn::LoadU(hn::Rebind<float, PairTag>(), from));
}

/// Every second pair, from lane `first` on.
template <int first, class D, class T>
HWY_INLINE hn::Vec<D> pairs_of(D d, const T* const* from, std::int64_t offset) {
  if constexpr (hn::MaxLanes(d) == 2) {
    return pair_at(from[first] + offset);
  } else if constexpr (hn::MaxLanes(d) == 4) {
    return hn::Combine(d, pair_at(from[first + 2] + offset), pair_at(from[first] + offset));
  } else {
    const hn::Half<D> half;
    return hn::Combine(d, pairs_of<first + 4>(half, from, offset),
                       pairs_of<first>(half, from, offset));
  }
}
#endif

/// The numbers at `offset` from each lane's place, and those next to them.
template <class D, class T>
HWY_INLINE void load_pairs(D d, const T* const* from, std::int64_t offset, hn::Vec<D>& first,
                           hn::Vec<D>& second) {
#if HWY_TARGET == HWY_SCALAR
  first = hn::Set(d, double(from[0][offset]));
  second = hn::Set(d, double(from[0][offset + 1]));
#else
  const hn::Vec<D> even = pairs_of<0>(d, from, offset), odd = pairs_of<1>(d, from, offset);
  first = hn::InterleaveLower(d, even, odd);
  second = hn::InterleaveUpper(d, even, odd);
#endif
}

} // namespace insitu::query::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

// Two packs as one number for the cell kernels, once per Highway target. Include after
// hwy/foreach_target.h, like any per-target header of Highway.
#if defined(INSITU_CELLS_PACK_PAIR_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INSITU_CELLS_PACK_PAIR_SIMD_H
#undef INSITU_CELLS_PACK_PAIR_SIMD_H
#else
#define INSITU_CELLS_PACK_PAIR_SIMD_H
#endif

#include "cells/kernels_simd.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::cells::HWY_NAMESPACE {

struct PackPairMask {
  PackMask a, b;
};

/// Newton's method waits for its own results most of the time; two at once take little longer than
/// one. A lane's bits are a scalar's, as a Pack's.
struct PackPair {
  Pack a, b;
  PackPair() = default;
  HWY_INLINE explicit PackPair(double x) : a(x), b(x) {}
  HWY_INLINE PackPair(const Pack& x, const Pack& y) : a(x), b(y) {}
};

HWY_INLINE PackPair operator+(const PackPair& x, const PackPair& y) {
  return {x.a + y.a, x.b + y.b};
}
HWY_INLINE PackPair operator-(const PackPair& x, const PackPair& y) {
  return {x.a - y.a, x.b - y.b};
}
HWY_INLINE PackPair operator*(const PackPair& x, const PackPair& y) {
  return {x.a * y.a, x.b * y.b};
}
HWY_INLINE PackPair operator/(const PackPair& x, const PackPair& y) {
  return {x.a / y.a, x.b / y.b};
}
HWY_INLINE PackPair operator-(const PackPair& x) {
  return {-x.a, -x.b};
}
HWY_INLINE PackPairMask operator<(const PackPair& x, const PackPair& y) {
  return {x.a < y.a, x.b < y.b};
}
HWY_INLINE PackPairMask operator>(const PackPair& x, const PackPair& y) {
  return {x.a > y.a, x.b > y.b};
}
HWY_INLINE PackPairMask operator==(const PackPair& x, const PackPair& y) {
  return {x.a == y.a, x.b == y.b};
}
HWY_INLINE PackPairMask operator|(const PackPairMask& x, const PackPairMask& y) {
  return {x.a | y.a, x.b | y.b};
}
HWY_INLINE PackPairMask operator&(const PackPairMask& x, const PackPairMask& y) {
  return {x.a & y.a, x.b & y.b};
}
HWY_INLINE PackPairMask operator!(const PackPairMask& x) {
  return {!x.a, !x.b};
}
HWY_INLINE bool all_of(const PackPairMask& x) {
  return all_of(x.a & x.b);
}
HWY_INLINE PackPair select(const PackPairMask& m, const PackPair& x, const PackPair& y) {
  return {select(m.a, x.a, y.a), select(m.b, x.b, y.b)};
}
HWY_INLINE PackPair absolute(const PackPair& x) {
  return {absolute(x.a), absolute(x.b)};
}
HWY_INLINE PackPair smaller(const PackPair& x, const PackPair& y) {
  return {smaller(x.a, y.a), smaller(x.b, y.b)};
}
HWY_INLINE PackPair larger(const PackPair& x, const PackPair& y) {
  return {larger(x.a, y.a), larger(x.b, y.b)};
}

} // namespace insitu::cells::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

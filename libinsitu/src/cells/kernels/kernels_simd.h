// The cell kernels over a SIMD pack, once per Highway target. Include after hwy/foreach_target.h,
// like any per-target header of Highway.
#if defined(INSITU_CELLS_KERNELS_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INSITU_CELLS_KERNELS_SIMD_H
#undef INSITU_CELLS_KERNELS_SIMD_H
#else
#define INSITU_CELLS_KERNELS_SIMD_H
#endif

#include <cmath>
#include <cstdint>
#include <hwy/highway.h>
#include <utility>

#include "cells/kernels/faces.h"
#include "math/hd.h"
#include "math/predicates.h"
#include "math/vec.h"
#include "mesh/shape.h"

HWY_BEFORE_NAMESPACE();
namespace insitu::cells::HWY_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

/// Up to eight doubles. Multiplication and addition are never fused, so that a lane's bits are a
/// scalar's.
using PackTag = hn::CappedTag<double, 8>;

struct PackMask {
  hn::Mask<PackTag> m;
};

struct Pack {
  hn::Vec<PackTag> v;
  Pack() = default;
  HWY_INLINE explicit Pack(double a) : v(hn::Set(PackTag(), a)) {}
  HWY_INLINE explicit Pack(hn::Vec<PackTag> a) : v(a) {}
};

HWY_INLINE Pack load_pack(const double* p) {
  return Pack(hn::Load(PackTag(), p));
}
/// A bit a lane.
HWY_INLINE unsigned lane_bits(const PackMask& mask) {
  std::uint8_t bytes[8] = {};
  hn::StoreMaskBits(PackTag(), mask.m, bytes);
  return bytes[0];
}

HWY_INLINE Pack operator+(const Pack& a, const Pack& b) {
  return Pack(hn::Add(a.v, b.v));
}
HWY_INLINE Pack operator-(const Pack& a, const Pack& b) {
  return Pack(hn::Sub(a.v, b.v));
}
HWY_INLINE Pack operator*(const Pack& a, const Pack& b) {
  return Pack(hn::Mul(a.v, b.v));
}
HWY_INLINE Pack operator/(const Pack& a, const Pack& b) {
  return Pack(hn::Div(a.v, b.v));
}
HWY_INLINE Pack operator-(const Pack& a) {
  return Pack(hn::Neg(a.v));
}
HWY_INLINE PackMask operator<(const Pack& a, const Pack& b) {
  return {hn::Lt(a.v, b.v)};
}
HWY_INLINE PackMask operator>(const Pack& a, const Pack& b) {
  return {hn::Lt(b.v, a.v)};
}
HWY_INLINE PackMask operator==(const Pack& a, const Pack& b) {
  return {hn::Eq(a.v, b.v)};
}
HWY_INLINE PackMask operator|(const PackMask& a, const PackMask& b) {
  return {hn::Or(a.m, b.m)};
}
HWY_INLINE PackMask operator&(const PackMask& a, const PackMask& b) {
  return {hn::And(a.m, b.m)};
}
HWY_INLINE PackMask operator!(const PackMask& a) {
  return {hn::Not(a.m)};
}
HWY_INLINE bool all_of(const PackMask& a) {
  return hn::AllTrue(PackTag(), a.m);
}
HWY_INLINE Pack select(const PackMask& m, const Pack& a, const Pack& b) {
  return Pack(hn::IfThenElse(m.m, a.v, b.v));
}
HWY_INLINE Pack absolute(const Pack& a) {
  return Pack(hn::Abs(a.v));
}
/// a < b ? a : b and a > b ? a : b, with a scalar's bits for NaN and zeros; x86's minimum is that.
HWY_INLINE Pack smaller(const Pack& a, const Pack& b) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
  return Pack(hn::Min(a.v, b.v));
#else
  return select(a < b, a, b);
#endif
}
HWY_INLINE Pack larger(const Pack& a, const Pack& b) {
#if HWY_ARCH_X86 && HWY_TARGET != HWY_SCALAR && HWY_TARGET != HWY_EMU128
  return Pack(hn::Max(a.v, b.v));
#else
  return select(a > b, a, b);
#endif
}

/// The sign bits of a pack; the other bits mean nothing.
struct PackSigns {
  hn::Vec<PackTag> v;
};
HWY_INLINE PackSigns signs(const Pack& a) {
  return {a.v};
}
HWY_INLINE PackSigns operator|(const PackSigns& a, const PackSigns& b) {
  return {hn::Or(a.v, b.v)};
}
HWY_INLINE PackSigns operator&(const PackSigns& a, const PackSigns& b) {
  return {hn::And(a.v, b.v)};
}
HWY_INLINE PackSigns operator^(const PackSigns& a, const PackSigns& b) {
  return {hn::Xor(a.v, b.v)};
}
HWY_INLINE PackSigns operator!(const PackSigns& a) {
  return {hn::Not(a.v)};
}
/// b where not a.
HWY_INLINE PackSigns and_not(const PackSigns& a, const PackSigns& b) {
  return {hn::AndNot(a.v, b.v)};
}
HWY_INLINE PackSigns or_and(const PackSigns& a, const PackSigns& b, const PackSigns& c) {
  return {hn::Or(a.v, hn::And(b.v, c.v))};
}
HWY_INLINE PackSigns xor3(const PackSigns& a, const PackSigns& b, const PackSigns& c) {
  return {hn::Xor(a.v, hn::Xor(b.v, c.v))};
}
HWY_INLINE PackSigns choose(const PackSigns& m, const PackSigns& a, const PackSigns& b) {
  return {hn::IfVecThenElse(m.v, a.v, b.v)};
}
HWY_INLINE PackMask lane_mask(const PackSigns& a) {
  const hn::RebindToSigned<PackTag> d;
  return {hn::MaskFromVec(hn::BitCast(PackTag(), hn::BroadcastSignBit(hn::BitCast(d, a.v))))};
}
/// a b + c and c - a b, fused where the target can: for bounds and signs, not for answers.
HWY_INLINE Pack mul_add(const Pack& a, const Pack& b, const Pack& c) {
  return Pack(hn::MulAdd(a.v, b.v, c.v));
}
HWY_INLINE Pack neg_mul_add(const Pack& a, const Pack& b, const Pack& c) {
  return Pack(hn::NegMulAdd(a.v, b.v, c.v));
}

/// Three packs, with operators of this target (math::Vec3's are compiled for the baseline).
template <class T>
struct Vec3 {
  T x, y, z;
  HWY_INLINE Vec3& operator+=(const Vec3& b) {
    x = x + b.x;
    y = y + b.y;
    z = z + b.z;
    return *this;
  }
};
template <class T>
HWY_INLINE Vec3<T> operator+(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}
template <class T>
HWY_INLINE Vec3<T> operator-(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}
template <class T>
HWY_INLINE Vec3<T> operator*(const T& s, const Vec3<T>& a) {
  return {s * a.x, s * a.y, s * a.z};
}
template <class T>
HWY_INLINE T dot(const Vec3<T>& a, const Vec3<T>& b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}
template <class T>
HWY_INLINE Vec3<T> cross(const Vec3<T>& a, const Vec3<T>& b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

using mesh::Shape;
using mesh::vertex_count;

#define INSITU_LAMBDA HWY_ATTR
#define INSITU_INLINE HWY_INLINE

#include "cells/kernels/contain_lanes.inl"
#include "cells/kernels/inverse_map.inl"
#include "cells/kernels/jacobian_signs.inl"
#include "cells/kernels/shape_functions.inl"

#undef INSITU_INLINE
#undef INSITU_LAMBDA

} // namespace insitu::cells::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

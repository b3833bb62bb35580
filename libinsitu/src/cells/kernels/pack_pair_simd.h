// Two packs as one number for the cell kernels, once per Highway target. Include after
// hwy/foreach_target.h, like any per-target header of Highway.
#if defined(INSITU_CELLS_PACK_PAIR_SIMD_H) == defined(HWY_TARGET_TOGGLE)
#ifdef INSITU_CELLS_PACK_PAIR_SIMD_H
#undef INSITU_CELLS_PACK_PAIR_SIMD_H
#else
#define INSITU_CELLS_PACK_PAIR_SIMD_H
#endif

#include <type_traits>

#include "cells/kernels/kernels_simd.h"

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

/// Puts a vector where invert_range wants it.
struct PutWhole {
  Vec3<Pack>* x;
  HWY_INLINE void operator()(int v, const Vec3<Pack>& of) const { x[v] = of; }
};
template <Pack PackPair::*half>
struct PutHalf {
  Vec3<PackPair>* x;
  HWY_INLINE void operator()(int v, const Vec3<Pack>& of) const {
    x[v].x.*half = of.x;
    x[v].y.*half = of.y;
    x[v].z.*half = of.z;
  }
};

/// Items [begin, end) of one shape, whose cells are `vectors` vectors each, two packs at a time:
/// map(x, p) inverts a cell's map. load(k, i, put, p) gives the k-th pack of the two, of items from
/// i on: each vector of its cells by put(v, vector), and its points; store(k, i, found) takes what
/// was found. The last pack may reach beyond the end.
template <int vectors, class Map, class Load, class Store>
HWY_INLINE void invert_range(const Map& map, int begin, int end, const Load& load,
                             const Store& store) {
  constexpr bool waits = vectors != 4; // for its own results: a tetrahedron's is no iteration
  const int lanes = int(hn::Lanes(PackTag()));
  int i = begin;
  for (; waits && end - i > lanes; i += 2 * lanes) {
    Vec3<PackPair> x[vectors];
    Vec3<Pack> p[2];
    load(0, i, PutHalf<&PackPair::a>{x}, p[0]);
    load(1, i + lanes, PutHalf<&PackPair::b>{x}, p[1]);
    const InverseMap<PackPair> both =
        map(static_cast<const Vec3<PackPair>*>(x),
            Vec3<PackPair>{{p[0].x, p[1].x}, {p[0].y, p[1].y}, {p[0].z, p[1].z}});
    store(0, i,
          InverseMap<Pack>{
              {both.r.x.a, both.r.y.a, both.r.z.a}, both.margin.a, both.converged.a, both.error.a});
    store(1, i + lanes,
          InverseMap<Pack>{
              {both.r.x.b, both.r.y.b, both.r.z.b}, both.margin.b, both.converged.b, both.error.b});
  }
  for (; i < end; i += lanes) {
    Vec3<Pack> x[vectors], p;
    load(0, i, PutWhole{x}, p);
    store(0, i, map(static_cast<const Vec3<Pack>*>(x), p));
  }
}

/// Calls f(vertices, map) with the number of a shape's vertices, a constant, and its inverse
/// map(x, p), of packs or pairs of packs.
template <class F>
HWY_INLINE void with_inverse(Shape shape, const F& f) {
  switch (shape) {
  case Shape::tetrahedron:
    return f(std::integral_constant<int, 4>(),
             [](const auto* x, const auto& p) HWY_ATTR { return inverse_tetrahedron(x, p); });
  case Shape::pyramid:
    return f(std::integral_constant<int, 5>(),
             [](const auto* x, const auto& p) HWY_ATTR { return inverse_pyramid(x, p); });
  case Shape::wedge:
    return f(std::integral_constant<int, 6>(),
             [](const auto* x, const auto& p) HWY_ATTR { return inverse_wedge(x, p); });
  default:
    return f(std::integral_constant<int, 8>(), [shape](const auto* x, const auto& p) HWY_ATTR {
      return inverse_hexahedron(shape, x, p);
    });
  }
}

} // namespace insitu::cells::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#endif

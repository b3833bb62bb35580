#pragma once

#include <cmath>
#include <utility>

#include "cells/kernels/faces.h"
#include "math/number.h"
#include "math/predicates.h"
#include "math/vec.h"
#include "mesh/shape.h"

/// The cell kernels for scalars, on the host and, under nvcc, on the device.
/// cells/kernels/kernels_simd.h includes the same text once per SIMD target.
namespace insitu::cells {

#define INSITU_LAMBDA // under nvcc, a lambda inside a kernel is compiled for where that kernel runs
#define INSITU_INLINE INSITU_HD inline

using math::absolute;
using math::all_of;
using math::larger;
using math::select;
using math::smaller;
using math::Vec3;
using mesh::Shape;
using mesh::vertex_count;

#include "cells/kernels/inverse_map.inl"
#include "cells/kernels/shape_functions.inl"

/// contain_lanes.inl needs the sign bit of a number, and products that the compiler may fuse with
/// sums.
struct SignBit {
  bool on;
};
INSITU_HD inline SignBit signs(double a) {
  return {std::signbit(a)};
}
INSITU_HD inline bool lane_mask(SignBit a) {
  return a.on;
}
INSITU_HD inline SignBit operator|(SignBit a, SignBit b) {
  return {a.on || b.on};
}
INSITU_HD inline SignBit operator&(SignBit a, SignBit b) {
  return {a.on && b.on};
}
INSITU_HD inline SignBit operator^(SignBit a, SignBit b) {
  return {a.on != b.on};
}
INSITU_HD inline SignBit operator!(SignBit a) {
  return {!a.on};
}
INSITU_HD inline SignBit and_not(SignBit a, SignBit b) {
  return {!a.on && b.on};
}
INSITU_HD inline SignBit or_and(SignBit a, SignBit b, SignBit c) {
  return {a.on || (b.on && c.on)};
}
INSITU_HD inline SignBit xor3(SignBit a, SignBit b, SignBit c) {
  return a ^ b ^ c;
}
INSITU_HD inline SignBit choose(SignBit m, SignBit a, SignBit b) {
  return m.on ? a : b;
}
INSITU_HD inline double mul_add(double a, double b, double c) {
  return a * b + c;
}
INSITU_HD inline double neg_mul_add(double a, double b, double c) {
  return c - a * b;
}

#include "cells/kernels/contain_lanes.inl"
#include "cells/kernels/jacobian_signs.inl"

#undef INSITU_INLINE
#undef INSITU_LAMBDA

} // namespace insitu::cells

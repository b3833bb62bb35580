#pragma once

#include <cmath>

#include "math/vec.h"
#include "mesh/shape.h"
#include "render/surface/tiles/patches.h"

namespace insitu::render {

/// The numbers of a cell's vertices as those of the corners of a cube: corner c has r = c & 1,
/// s = c >> 1 & 1, u = c >> 2 of the cell's parametric coordinates. Wedges and tetrahedra become
/// the half and the sixth of a cube whose other corners follow linearly, and a pyramid's upper
/// corners are one.
template <class T>
void to_corners(mesh::Shape shape, const T* v, T (&corner)[8]) {
  switch (shape) {
  case mesh::Shape::tetrahedron:
    for (int c = 0; c < 8; ++c) {
      corner[c] = v[0];
      for (int a = 0; a < 3; ++a)
        if (c >> a & 1)
          corner[c] += v[a + 1] - v[0];
    }
    return;
  case mesh::Shape::wedge:
    for (int c = 0; c < 8; ++c) {
      const T* const triangle = v + (c & 4 ? 3 : 0);
      corner[c] = triangle[c & 1 ? 1 : c & 2 ? 2 : 0];
      if ((c & 3) == 3)
        corner[c] += triangle[2] - triangle[0];
    }
    return;
  case mesh::Shape::pyramid:
    for (int c = 0; c < 8; ++c)
      corner[c] = c & 4 ? v[4] : v[c < 2 ? c : 5 - c];
    return;
  default: {
    const int turn = shape == mesh::Shape::voxel ? 0 : 1; // voxels count j before turning
    for (int c = 0; c < 8; ++c)
      corner[c] = v[c & 2 ? c ^ turn : c];
    return;
  }
  }
}

inline PatchDomain domain_of(mesh::Shape shape) {
  return shape == mesh::Shape::tetrahedron ? PatchDomain::simplex
         : shape == mesh::Shape::wedge     ? PatchDomain::prism
                                           : PatchDomain::cube;
}

/// A cell's map and field as polynomials, for the gradients at many of its points.
class TrilinearCell {
public:
  TrilinearCell() = default;
  TrilinearCell(mesh::Shape shape, const math::Vec3d* x, const double* values)
      : is_linear_(shape == mesh::Shape::tetrahedron) {
    math::Vec3d point[8];
    double f[8];
    to_corners(shape, x, point);
    to_corners(shape, values, f);
    set_slopes(point, x_);
    set_slopes(f, f_);
    if (is_linear_)
      constant_ = solve({});
  }

  /// The physical gradient of the field at parametric coordinates, of any length: infinite or not a
  /// number where the cell is degenerate.
  math::Vec3d gradient(const math::Vec3d& r) const { return is_linear_ ? constant_ : solve(r); }

private:
  /// The coefficients of r, s, u, rs, su, ru, rsu.
  template <class T>
  static void set_slopes(const T (&c)[8], T (&k)[7]) {
    k[0] = c[1] - c[0];
    k[1] = c[2] - c[0];
    k[2] = c[4] - c[0];
    k[3] = c[3] - c[2] - k[0];
    k[4] = c[6] - c[4] - k[1];
    k[5] = c[5] - c[4] - k[0];
    k[6] = (c[7] - c[6]) - (c[5] - c[4]) - k[3];
  }
  template <class T>
  static void derivatives(const T (&k)[7], const math::Vec3d& r, T (&d)[3]) {
    d[0] = k[0] + r.y * k[3] + r.z * (k[5] + r.y * k[6]);
    d[1] = k[1] + r.x * k[3] + r.z * (k[4] + r.x * k[6]);
    d[2] = k[2] + r.x * k[5] + r.y * (k[4] + r.x * k[6]);
  }
  /// J^T g = d f / d(r, s, u): by cross products of the map's derivatives.
  math::Vec3d solve(const math::Vec3d& r) const {
    math::Vec3d x[3];
    double f[3];
    derivatives(x_, r, x);
    derivatives(f_, r, f);
    const math::Vec3d a = cross(x[1], x[2]), b = cross(x[2], x[0]), c = cross(x[0], x[1]);
    return (f[0] * a + f[1] * b + f[2] * c) / dot(x[0], a);
  }

  math::Vec3d x_[7], constant_;
  double f_[7] = {};
  bool is_linear_ = false;
};

} // namespace insitu::render

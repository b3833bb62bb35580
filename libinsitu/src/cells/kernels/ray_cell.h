#pragma once

#include <cstdint>

#include "math/vec.h"
#include "mesh/view.h"

namespace insitu::cells {

/// A ray of unit direction, so that distances along it are lengths.
struct Ray {
  math::Vec3d origin, direction;
};

/// A frame of reference whose third axis is the ray: (0, 0, t) is the point at distance t.
class RaySpace {
public:
  explicit RaySpace(const Ray& ray);
  math::Vec3d operator()(const math::Vec3d& p) const {
    const math::Vec3d r = p - ray_.origin;
    return {dot(r, right_), dot(r, up_), dot(r, ray_.direction)};
  }
  const Ray& ray() const { return ray_; }

private:
  Ray ray_;
  math::Vec3d right_, up_;
};

/// Where a ray meets a face of a cell: the distance, and weights of the face's vertices there.
struct Crossing {
  double t = 0;
  int count = 0; ///< 3 or 4
  std::uint8_t vertices[4] = {};
  double weights[4] = {};

  /// The field there, never beyond the values at the face's vertices: exact where these are equal.
  double value(const double* at_vertices) const {
    double low = at_vertices[vertices[0]], high = low, sum = weights[0] * low;
    for (int k = 1; k < count; ++k) {
      const double v = at_vertices[vertices[k]];
      low = v < low ? v : low;
      high = v > high ? v : high;
      sum += weights[k] * v;
    }
    return sum < low ? low : sum > high ? high : sum;
  }
  /// The cell's parametric coordinates of the point.
  math::Vec3d parametric(mesh::Shape shape) const;
};

constexpr int most_crossings = 12;

/// The ray's crossings with the cell's triangles and bilinear quads, ascending in t; returns how
/// many. Both cells at a face compute the same bits for it: vertices are put into ray space one by
/// one, and faces are evaluated in an order that depends on coordinates alone. Inside tests use
/// edge functions, which two faces at an edge get with exactly opposite signs, so rays do not slip
/// through (Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection", section 3); patches
/// whose projection folds, or that the ray meets on their rim, are solved with a tolerance, which
/// can report a crossing twice but loses none.
int face_crossings(const mesh::CellVertices& cell, const RaySpace& space, Crossing* out);

} // namespace insitu::cells

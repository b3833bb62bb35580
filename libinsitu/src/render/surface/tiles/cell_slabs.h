#pragma once

#include <cstdint>

#include "math/vec.h"
#include "mesh/shape.h"

namespace insitu::render {

/// Up to 16 rays beside cells, a ray a lane.
struct RayLanes {
  static constexpr int most = 16;
  alignas(64) double origin[3][most] = {};
  alignas(64) float direction[3][most] = {};
  alignas(64) float t_max[most] = {};
};

/// Slabs that hold a cell and the surfaces within it, by which rays are told to have no hit there
/// without a look at its vertices.
///
/// For any vector n, n x over the cell lies between its least and its greatest at the vertices:
/// weights of vertices are positive and add up to one. The cell's own axes are taken, and across
/// the slanted face of wedges and tetrahedra. So does what a linear function leaves of the field:
/// where the field is a level, g x lies between two numbers, and with the field's mean gradient as
/// g these are near to each other. A ray that is never in all slabs at once has no hit.
///
/// Besides, with the mean inverse derivatives M of the map, |M J - 1| <= e < 1 in each row, and
/// derivatives of what is left along axis a that are no larger than h_a, f(p) - f(q) is g (p - q)
/// but for the sum of h_a (|M_a (p - q)| + e / (1 - e) max|M (p - q)|), for any two points of the
/// cell (the mean value theorem, along the straight line in parametric coordinates).
struct CellSlabs {
  static constexpr int most = 5;
  /// Of an even normal that is none: the slab holds everything.
  struct Slab {
    float normal[3]; ///< of length 1, or 0
    float from, to;  ///< of the normal times (p - centre) / size
  };

  math::Vec3d centre;
  double inverse_size = 0;  ///< 0: nothing is known of the cell
  double low = 0, high = 0; ///< of the values
  int count = 0;            ///< of slabs
  Slab slab[most];          ///< the first one is the field's, of the part of values that is 0
  double place = 0;         ///< by how much its ends move from the least value to the largest
  float rounding = 0;       ///< of a position, over the size
  float length[3];          ///< |M_a|, whose directions are the normals of slabs 1 to 3
  float left[3];            ///< h_a / |g|
  float error = 1;          ///< e

  CellSlabs() = default;
  /// x, values: of n vertices. The values are finite.
  CellSlabs(mesh::Shape shape, int n, const math::Vec3d* x, const double* values);

  /// Bits of rays, among those of `rays`, that may have a hit on the level in the cell.
  unsigned may_meet(const RayLanes& lanes, unsigned rays, double level) const;
  /// Whether a ray that starts on the surface of a level at a point of the cell, raised along a
  /// normal by `clearance`, surely does not meet the level in the cell again.
  bool leaves(const math::Vec3d& normal, double clearance, const math::Vec3d& direction) const;

private:
  double wander(const math::Vec3d& along) const;
};

} // namespace insitu::render

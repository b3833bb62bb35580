#pragma once

#include <limits>

#include "cells/exact/decide.h"
#include "math/vec.h"
#include "mesh/shape.h"

/// Which point of a cell's boundary is nearest to a place.
namespace insitu::query {

/// How lengths are measured around a place: along each axis a coordinate's step is so long.
struct Metric {
  math::Vec3d scale = {1.0, 1.0, 1.0};

  math::Vec3d from(const math::Vec3d& p, const math::Vec3d& x) const {
    return {(x.x - p.x) * scale.x, (x.y - p.y) * scale.y, (x.z - p.z) * scale.z};
  }
};

struct NearestOnCell {
  double squared = std::numeric_limits<double>::infinity(); ///< of the distance
  math::Vec3d point;                                        ///< in the cell's coordinates
  cells::Decision on; ///< the face, edge or vertex that holds it; outside: none is near enough
};

/// The point of the cell's boundary that is nearest to p, if its squared distance is at most
/// `most`. x: the vertices. Faces of four vertices are bilinear patches, on which bounds lead to
/// the nearest point: a part of a patch lies no farther from a parallelogram than a quarter of the
/// part's twist, and parts are halved until none could be nearer by more than rounding. What is
/// found on a face, an edge or a vertex is the same to the bit from all cells that share it.
NearestOnCell nearest_on_cell(mesh::Shape shape, const math::Vec3d* x, const math::Vec3d& p,
                              const Metric& metric, double most);

} // namespace insitu::query

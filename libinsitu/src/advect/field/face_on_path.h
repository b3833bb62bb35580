#pragma once

#include "advect/integrate/dense.h"
#include "math/vec.h"
#include "mesh/view.h"

namespace insitu::advect {

/// A place on a path, and its coordinates in a cell.
struct PlaceOnPath {
  double theta = -1.0; ///< negative: none
  math::Vec3d r;
};

/// Where a path goes out of a cell, between `low` and `high` of it: on the inside of a face, by a
/// part of control::on_face, inside of it before, and not beyond another. r: the coordinates at
/// `high`, which is outside. along: faces that are no ends, a bit each. By Newton's method for the
/// coordinates and theta at once. None for pyramids, and where it does not converge: then there may
/// be such a place all the same.
PlaceOnPath face_on_path(const mesh::CellVertices& cell, unsigned along, const DenseStep& path,
                         double low, double high, const math::Vec3d& r);

/// Whether a path that ends in a cell, at these coordinates, is surely inside at its quarters too;
/// false if that takes more than a Newton's step each to tell.
bool is_inside_before(const mesh::CellVertices& cell, unsigned along, const DenseStep& path,
                      const math::Vec3d& r);

} // namespace insitu::advect

#pragma once

#include "cells/kernels/ray_cell.h"
#include "math/vec.h"
#include "mesh/view.h"

namespace insitu::render {

/// Lower and upper bound.
struct Bounds {
  double low, high;

  bool has_zero() const { return low <= 0 && high >= 0; }
};

/// Bounds on a field along a ray within a cell, where the ray's path through parametric space is
/// curved.
///
/// Position and field are affine in each of r, s, t alone (of VTK's pyramids and wedges too), so on
/// a parametric box they and their derivatives take their extremes at corners. The path obeys
/// dr/dt = J^-1 d; a box that holds the start plus the time times the bounds of J^-1 d over the box
/// itself holds the path (Picard). Over that box the field's range may exclude the level, or the
/// sign of df/dt = det(d(x, y, f)/d(r, s, t)) / det(d(x, y, z)/d(r, s, t)), in a space whose z is
/// along the ray, may be definite. Bounds are widened by far more than their rounding.
class PathBounds {
public:
  PathBounds(const mesh::CellVertices& cell, const cells::RaySpace& space);

  /// The field's values at the cell's vertices; what is told is relative to the level.
  void set_values(const double* values, double level);

  /// What is known of the field between two points of the path, `length` apart.
  struct Known {
    bool path = false;     ///< false: no box could be found that holds the path
    Bounds field{0, 0};    ///< if path
    bool monotone = false; ///< if path: the slope has one sign
  };
  Known operator()(const math::Vec3d& from, const math::Vec3d& to, double length) const;

private:
  struct Box {
    math::Vec3d low, high;
  };
  /// An affine-in-each function by its values at the reference cube's corners, r fastest.
  using Corners = double[8];
  Bounds range(const Corners& f, const Box& box) const;
  void derivatives(const Corners& f, const Box& box, Bounds (&d)[3]) const;
  bool path_rates(const Box& box, const Bounds (&dx)[3], const Bounds (&dy)[3],
                  Bounds (&rates)[3]) const;
  void spread(const double* at_vertices, Corners& out) const;

  mesh::Shape shape_;
  int count_;
  double weights_[8][8]; ///< of the vertices at the cube's corners
  Corners x_, y_, z_, f_ = {};
};

} // namespace insitu::render

#pragma once

#include <cstdint>
#include <optional>

#include "cells/kernels/ray_cell.h"
#include "core/parallel.h"
#include "render/path/path_bounds.h"

namespace insitu::render {

/// A point of a ray on a level of a cell's field.
struct LevelHit {
  double t = 0;
  math::Vec3d parametric;
  math::Vec3d gradient; ///< of the field, in physical space, at the point
};

enum class RootSearch { neubauer, cubic, exact };

/// Finds where a vertex field, along a ray within one cell, passes a level.
///
/// The ray's stretch inside the cell ends on faces, where the field is known from the face's
/// vertices alone, to the same bits in both cells that share it. A value at or above the level
/// counts as above, so a change of side between two faces is seen by exactly one cell, and no ray
/// slips through a surface between cells. A surface separates what is at or above the level from
/// what is below: where a field's least value on a boundary is the level, there is none, and where
/// its greatest is, all of that boundary is one. In between, `cubic` tracks the field by cubics
/// that match values and derivatives at both ends (exact in cells that are parallelepipeds or
/// tetrahedra) and are halved until they also meet the field in the middle; each change of side is
/// bracketed between the cubic's extrema. Single roots are never missed; pairs closer than the
/// cubic's remaining error (1/64 of the values' spread in the cell, of its halves 16 times better)
/// can be. `exact` halves the stretch until PathBounds exclude the level from a part or show it
/// monotone there, when a change of side brackets exactly one root, which Newton's method refines
/// within the bracket. So pairs of roots are found as well; those that can be missed are nearer to
/// each other than 2^-20 of the stretch, have less than 1e-10 of the values' spread between them,
/// or lie where the cell folds or collapses. `neubauer` looks for a change of side over the stretch
/// alone and interpolates linearly twice (Neubauer et al. 2002; Rathke et al. 2015, section 5): it
/// finds one root of one or three, and none of two.
class CellRoots {
public:
  /// Prepares a cell for a ray; only stretches that meet [t_near, t_far] count, and nothing before
  /// t_near. Cell and space must outlive this.
  CellRoots(const mesh::CellVertices& cell, const cells::RaySpace& space, double t_near,
            double t_far);
  CellRoots(const CellRoots&) = delete;
  CellRoots& operator=(const CellRoots&) = delete;

  /// Whether the ray passes through the cell.
  bool meets() const { return stretches_ > 0; }
  /// From its first to its last crossing.
  double extent() const { return extent_; }

  /// Calls found(hit) for each root in ascending order, until it returns false. `values` are the
  /// field's at the cell's vertices.
  void find(const double* values, double level,
            const core::FunctionRef<bool(const LevelHit&)>& found,
            RootSearch search = RootSearch::cubic);

  /// Field evaluations that needed the inverse map, so far.
  std::int64_t evaluations() const { return evaluations_; }

private:
  struct Point {
    double t = 0, f = 0, slope = 0; ///< f relative to the level
    math::Vec3d parametric, gradient;
  };
  struct Stretch {
    int first, last; ///< crossings
  };
  Point at_crossing(const cells::Crossing& c) const;
  Point evaluate(double t);
  void finish(Point& p) const;
  bool is_linear(const Point& a, const Point& b) const;
  bool report_linear(const Point& a, const Point& b);
  bool search(const Point& a, const Point& b, int depth);
  bool track(const Point& a, const Point& b, int depth); ///< `cubic`
  bool search_cubic(const Point& a, const Point& b, double error);
  bool search_twice(Point a, Point b);
  bool bracket(Point a, Point b);
  bool report(const Point& p);

  const mesh::CellVertices& cell_;
  const cells::RaySpace& space_;
  double t_near_;
  cells::Crossing crossings_[cells::most_crossings];
  Stretch stretch_[cells::most_crossings];
  int stretches_ = 0;
  std::int64_t evaluations_ = 0;
  std::optional<PathBounds> bounds_; ///< once they are needed
  // Of the current find().
  const double* values_ = nullptr;
  double level_ = 0, extent_ = 0;
  double low_ = 0, high_ = 0; ///< of the values
  double span_ = 0;           ///< of the values
  double spread_ = 0;         ///< of the values from the level
  int parts_ = 0;
  bool bounds_are_set_ = false; ///< for values_
  const core::FunctionRef<bool(const LevelHit&)>* found_ = nullptr;
};

} // namespace insitu::render

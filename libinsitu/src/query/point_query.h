#pragma once

#include "query/sampler.h"

/// What single and batched queries share: the query's box, the decision, the coordinates.
namespace insitu::query {

struct PointQuery {
  const mesh::MeshView& mesh;
  const accel::Tree& tree;
  LocateOptions options;

  /// The query's box in the tree's frame, rounded outwards; wider while the mesh is between two
  /// steps, since boxes hold the current one. False for points that are not finite or beyond any
  /// mesh.
  bool box(const math::Vec3d& p, float* lower, float* upper) const;

  /// One point, depth first.
  Location locate(const math::Vec3d& p, Reason& reason) const;
};

/// Whether the closed cell holds the point, and why: exact. x: the cell's vertices.
Reason decide(mesh::Shape shape, const math::Vec3d* x, const math::Vec3d& p);

/// Whether what Newton found in a cell that holds the point is where it lies.
inline bool is_plausible(bool converged, double margin) {
  return converged && margin >= -1e-3;
}

/// The parametric coordinates of a point in a cell that holds it.
math::Vec3d parametric_in(mesh::Shape shape, const math::Vec3d* x, const math::Vec3d& p);

} // namespace insitu::query

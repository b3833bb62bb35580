#include "query/attached.h"

#include <cmath>

#include "cells/kernels.h"

namespace insitu::query {

math::Vec3d position(const mesh::MeshView& mesh, const Location& at) {
  mesh::CellVertices c;
  mesh::gather(mesh, at.cell, c);
  double weight[8];
  cells::shape_functions(c.shape, at.parametric, weight);
  math::Vec3d x;
  for (int v = 0; v < c.count; ++v)
    x += weight[v] * c.x[v];
  return x;
}

bool follow(const Sampler& sampler, bool same_cells, const LocateOptions& options, Location& at,
            math::Vec3d& x) {
  if (!same_cells || !at || at.cell >= sampler.mesh().cell_count()) {
    at = sampler.locate(x, -1, options);
    return bool(at);
  }
  const math::Vec3d moved = position(sampler.mesh(), at);
  if (!(std::isfinite(moved.x) && std::isfinite(moved.y) && std::isfinite(moved.z))) {
    at = {};
    return false;
  }
  x = moved;
  return true;
}

} // namespace insitu::query

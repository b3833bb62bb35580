#include "torture/truth.h"

#include <algorithm>
#include <cmath>

#include "cells/kernels/kernels.h"

namespace insitu::bench::torture {

using math::Vec3d;

Truth find_owners(const workload::Mesh& mesh, const std::vector<Point>& points) {
  const auto cells = std::size_t(mesh.cell_count());
  std::vector<Vec3d> low(cells), high(cells);
  for (std::size_t c = 0; c < cells; ++c) {
    Vec3d x[8];
    const int n = mesh.gather(std::int64_t(c), x);
    low[c] = high[c] = x[0];
    for (int v = 1; v < n; ++v)
      for (int a = 0; a < 3; ++a) {
        low[c][a] = std::min(low[c][a], x[v][a]);
        high[c][a] = std::max(high[c][a], x[v][a]);
      }
  }
  Truth out;
  for (const Point& point : points) {
    const Vec3d& p = point.at;
    std::int64_t owner = -1;
    auto in_owner = cells::Containment::outside;
    int inside = 0;
    for (std::size_t c = 0; c < cells; ++c) {
      if (p.x < low[c].x || p.x > high[c].x || p.y < low[c].y || p.y > high[c].y ||
          p.z < low[c].z || p.z > high[c].z)
        continue;
      Vec3d x[8];
      mesh.gather(std::int64_t(c), x);
      const auto where = cells::contain_exact(mesh.shape(std::int64_t(c)), x, p).where;
      if (owner < 0 && cells::holds(where)) {
        owner = std::int64_t(c);
        in_owner = where;
      }
      inside += where == cells::Containment::inside;
    }
    out.owners.push_back(owner);
    out.where.push_back(in_owner);
    out.owned += owner >= 0;
    out.gaps += owner < 0 && point.within;
    out.overlaps += inside > 1;
  }
  return out;
}

double mapped_error(const workload::Mesh& mesh, std::int64_t cell, const Vec3d& parametric,
                    const Vec3d& p) {
  Vec3d x[8];
  double w[8];
  const int n = mesh.gather(cell, x);
  cells::shape_functions(mesh.shape(cell), parametric, w);
  Vec3d miss = x[0] - p; // relative to a vertex: an offset's rounding is not the map's
  double squared_diameter = 0.0;
  for (int v = 1; v < n; ++v) {
    miss += w[v] * (x[v] - x[0]);
    for (int u = 0; u < v; ++u)
      squared_diameter = std::max(squared_diameter, dot(x[v] - x[u], x[v] - x[u]));
  }
  const double distance = std::sqrt(dot(miss, miss));
  return distance == 0.0 ? 0.0 : distance / std::sqrt(squared_diameter);
}

} // namespace insitu::bench::torture

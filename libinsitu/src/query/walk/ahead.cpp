#include "query/walk/ahead.h"

#include <algorithm>
#include <limits>
#include <vector>

#include "accel/tree/tree.h"
#include "cells/kernels/ray_cell.h"

namespace insitu::query {

using math::Vec3d;

namespace {

/// Whether the line from p, in the tree's frame, comes into a box that is `wider` on all sides.
bool meets(const accel::Box& box, const Vec3d& p, const Vec3d& d, double wider) {
  double enters = 0.0, leaves = std::numeric_limits<double>::infinity();
  for (int a = 0; a < 3; ++a) {
    const double low = double(box.lower[a]) - wider - p[a];
    const double high = double(box.upper[a]) + wider - p[a];
    if (d[a] == 0.0) {
      if (low > 0.0 || high < 0.0)
        return false;
      continue;
    }
    enters = std::max(enters, std::min(low / d[a], high / d[a]));
    leaves = std::min(leaves, std::max(low / d[a], high / d[a]));
  }
  return enters <= leaves * (1.0 + 1e-14);
}

} // namespace

bool meets_cells_ahead(const Sampler& sampler, const Vec3d& from, const Vec3d& direction,
                       double alpha) {
  const accel::Tree& tree = sampler.tree();
  const mesh::MeshView& mesh = sampler.mesh();
  if (tree.empty())
    return false;
  const Vec3d p = from - tree.origin();
  const double wider = alpha == 1.0 ? 0.0 : mesh.largest_displacement;
  const cells::RaySpace space({from, direction});
  std::vector<std::uint32_t> stack{0};
  while (!stack.empty()) {
    const accel::Node& node = tree.nodes()[stack.back()];
    stack.pop_back();
    for (int c = 0; c < 8; ++c) {
      if (!node.meta[c] || !meets(node.child_box(c), p, direction, wider))
        continue;
      if (node.is_inner(c)) {
        stack.push_back(node.child_node(c));
        continue;
      }
      for (int k = 0; k < node.child_cell_count(c); ++k) {
        const std::int64_t flat = tree.cells()[node.child_cells(c) + std::uint32_t(k)];
        if (flat < mesh.first_single_cell())
          return true;
        mesh::CellVertices cell;
        mesh::gather(mesh, flat, cell, alpha);
        cells::Crossing crossings[cells::most_crossings];
        const int n = cells::face_crossings(cell, space, crossings);
        if (n > 0 && crossings[n - 1].t > 0.0)
          return true;
      }
    }
  }
  return false;
}

} // namespace insitu::query

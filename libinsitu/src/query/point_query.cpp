#include "query/point_query.h"

#include <cmath>

#include "cells/contain_exact.h"
#include "cells/kernels.h"
#include "cells/robust_inverse.h"

namespace insitu::query {

using math::Vec3d;

BoxRule::BoxRule(const Vec3d& origin_, double alpha, double moved) : origin(origin_) {
  if (alpha == 1.0 || moved == 0.0)
    return;
  // The blend's rounding, at the size of the coordinates, and that of the first term.
  wider_relative = 0x1p-50;
  wider = (1.0 - alpha) * moved * 1.0000001 + wider_relative * moved;
}

bool BoxRule::box(const Vec3d& p, float* lower, float* upper) const {
  bool finite = true;
  for (int a = 0; a < 3; ++a) {
    const double d = p[a] - origin[a], w = wider + wider_relative * std::fabs(p[a]);
    finite &= std::fabs(d) <= farthest;
    lower[a] = accel::round_down(d - w);
    upper[a] = accel::round_up(d + w);
  }
  return finite;
}

Reason decide(mesh::Shape shape, const Vec3d* x, const Vec3d& p) {
  const cells::ExactResult result = cells::contain_exact(shape, x, p);
  switch (result.where) {
  case cells::Containment::inside:
    return result.exact_used ? Reason::exact : Reason::certified;
  case cells::Containment::on_face:
    return Reason::on_face;
  case cells::Containment::on_edge:
    return Reason::on_edge;
  case cells::Containment::on_vertex:
    return Reason::on_vertex;
  default:
    return Reason::outside;
  }
}

Vec3d parametric_in(mesh::Shape shape, const Vec3d* x, const Vec3d& p) {
  const auto map = cells::inverse_map(shape, x, p);
  return is_plausible(map.converged, map.margin) ? map.r : cells::robust_inverse(shape, x, p);
}

Location PointQuery::locate(const Vec3d& p, Reason& reason) const {
  Location best;
  reason = Reason::outside;
  float lower[3], upper[3];
  if (tree.empty() || !box_rule().box(p, lower, upper))
    return best;
  mesh::CellVertices owner;
  std::uint32_t stack[64 * 8];
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const accel::Node& node = tree.nodes()[stack[--size]];
    for (int c = 0; c < 8; ++c) {
      if (!node.meta[c])
        continue;
      const accel::Box b = node.child_box(c);
      if (!(b.lower[0] <= upper[0] && lower[0] <= b.upper[0] && b.lower[1] <= upper[1] &&
            lower[1] <= b.upper[1] && b.lower[2] <= upper[2] && lower[2] <= b.upper[2]))
        continue;
      if (node.is_inner(c)) {
        stack[size++] = node.child_node(c);
        continue;
      }
      for (int k = 0; k < node.child_cell_count(c); ++k) {
        const auto flat = std::int64_t(tree.cells()[node.child_cells(c) + std::uint32_t(k)]);
        if (best && flat > best.cell)
          continue;
        mesh::CellVertices cell;
        mesh::gather(mesh, flat, cell, options.alpha);
        if (const Reason why = decide(cell.shape, cell.x, p); why != Reason::outside) {
          best.cell = flat;
          reason = why;
          owner = cell;
        }
      }
    }
  }
  if (best)
    best.parametric = parametric_in(owner.shape, owner.x, p);
  return best;
}

} // namespace insitu::query

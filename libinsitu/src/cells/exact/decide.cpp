#include "cells/exact/decide.h"

#include "cells/exact/robust_inverse.h"
#include "cells/kernels/kernels.h"
#include "cells/kernels/on_feature.h"
#include "math/predicates_exact.h"

namespace insitu::cells {

using math::Vec3d;

Decision decide(mesh::Shape shape, const Vec3d* x, const Vec3d& p) {
  return decision_of(contain_exact(shape, x, p));
}

Vec3d parametric_in(mesh::Shape shape, const Vec3d* x, const Vec3d& p, const Decision& decision) {
  const auto map = inverse_map(shape, x, p);
  return put_on(shape, decision,
                is_plausible(map.converged, map.margin)
                    ? put_on_nearest(shape, x, p, map.r, map.error)
                    : robust_inverse(shape, x, p));
}

Vec3d put_on_faces_of(mesh::Shape shape, const Vec3d* x, const Vec3d& p, const Vec3d& r,
                      double near) {
  const FaceTable table = face_table(shape);
  math::Predicates predicates;
  double weights[8];
  shape_functions(shape, r, weights);
  unsigned on = 0xff, curved = 0;
  for (int f = 0; f < table.face_count; ++f) {
    const Face& face = table.faces[f];
    if (!(std::fabs(parametric_distance(shape, f, weights)) <= near))
      continue;
    const auto in_plane = [&](int i, int j, int k) {
      const auto& v = face.vertices;
      return predicates.orient3d(x[v[i]], x[v[j]], x[v[k]], p) == 0;
    };
    if (in_plane(0, 1, 2) && (face.vertex_count == 3 || (in_plane(0, 2, 3) && in_plane(0, 1, 3)))) {
      unsigned corners = 0;
      for (int k = 0; k < face.vertex_count; ++k)
        corners |= 1u << face.vertices[k];
      on &= corners;
    } else {
      curved += face.vertex_count == 4;
    }
  }
  if (curved > 0) {
    if (const unsigned corners = vertices_of(shape, decide(shape, x, p)); corners != 0)
      on &= corners;
    for (int e = 0; e < table.edge_count; ++e) {
      const Vec3d &a = x[table.edges[e].vertices[0]], &b = x[table.edges[e].vertices[1]];
      bool in_line = true;
      for (int axis = 0; axis < 3; ++axis) {
        const int u = (axis + 1) % 3, w = (axis + 2) % 3;
        in_line = in_line && predicates.orient2d(a[u], a[w], b[u], b[w], p[u], p[w]) == 0;
      }
      if (in_line && !(a == b))
        on &= 1u << table.edges[e].vertices[0] | 1u << table.edges[e].vertices[1];
    }
  }
  return on == 0xff ? r : put_on(shape, on, r);
}

} // namespace insitu::cells

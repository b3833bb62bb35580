#pragma once

#include "cells/exact/decide.h"
#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"
#include "math/hd.h"
#include "math/vec.h"
#include "mesh/shape.h"

/// Parametric coordinates of points on a cell's boundary: where a point lies on a face, edge or
/// vertex, or as near as an inverse map can tell, the weights (shape_functions) of the vertices
/// that are not on it are 0, to the bit. What is proven to be within a cell is further away.
namespace insitu::cells {

/// The local vertices, a bit each, of the face, edge or vertex that a decision names; 0: none.
INSITU_HD inline unsigned vertices_of(mesh::Shape shape, const Decision& decision) {
  const FaceTable table = face_table(shape);
  const int feature = decision.feature();
  unsigned on = 0;
  if (decision.reason() == Reason::on_vertex && feature >= 0)
    on = 1u << feature;
  if (decision.reason() == Reason::on_edge && feature >= 0)
    for (const std::uint8_t v : table.edges[feature].vertices)
      on |= 1u << v;
  if (decision.reason() == Reason::on_face && feature >= 0)
    for (int k = 0; k < table.faces[feature].vertex_count; ++k)
      on |= 1u << table.faces[feature].vertices[k];
  return on;
}

/// The local vertices, a bit each, at which a parametric coordinate is 0, and at which it is 1;
/// slanted: those of the face where their sum is 1 (0: none has that). A pyramid's apex counts for
/// all r and s.
struct ReferenceVertices {
  unsigned zero[3], one[3], slanted;
};
INSITU_HD inline ReferenceVertices reference_vertices(mesh::Shape shape) {
  switch (shape) {
  case mesh::Shape::tetrahedron:
    return {{0x0d, 0x0b, 0x07}, {0x02, 0x04, 0x08}, 0x0e};
  case mesh::Shape::pyramid:
    return {{0x19, 0x13, 0x0f}, {0x16, 0x1c, 0x10}, 0};
  case mesh::Shape::wedge:
    return {{0x2d, 0x1b, 0x07}, {0x12, 0x24, 0x38}, 0x36};
  case mesh::Shape::voxel:
    return {{0x55, 0x33, 0x0f}, {0xaa, 0xcc, 0xf0}, 0};
  default:
    return {{0x99, 0x33, 0x0f}, {0x66, 0xcc, 0xf0}, 0};
  }
}

/// Coordinates that differ from r by what puts them on the smallest face, edge or vertex with these
/// vertices (bits; 0: r itself).
INSITU_HD inline math::Vec3d put_on(mesh::Shape shape, unsigned on, math::Vec3d r) {
  if (on == 0)
    return r;
  const ReferenceVertices at = reference_vertices(shape);
  if (shape == mesh::Shape::pyramid && on == 0x10)
    return {0.5, 0.5, 1.0};
  for (int a = 0; a < 3; ++a)
    if ((on & ~at.zero[a]) == 0)
      r[a] = 0.0;
    else if ((on & ~at.one[a]) == 0)
      r[a] = 1.0;
  if ((on & ~at.slanted) != 0)
    return r;
  // As shape_functions subtracts: 1 - r - s (- t) is 0.
  r.x = r.x < 0.0 ? 0.0 : r.x > 1.0 ? 1.0 : r.x;
  const double rest = 1.0 - r.x;
  if (shape == mesh::Shape::wedge || (on & ~at.zero[2]) == 0) {
    r.y = rest;
  } else {
    r.z = rest - r.y;
    if (r.z < 0.0)
      r = {r.x, rest, 0.0};
  }
  return r;
}
INSITU_HD inline math::Vec3d put_on(mesh::Shape shape, const Decision& decision,
                                    const math::Vec3d& r) {
  return decision.is_on_boundary() ? put_on(shape, vertices_of(shape, decision), r) : r;
}

/// How far parametric coordinates lie from each face of a shape, at most six; returns how many
/// there are. To rounding the same as parametric_distance of their weights.
INSITU_HD inline int parametric_distances(mesh::Shape shape, const math::Vec3d& r,
                                          double* distance) {
  if (shape == mesh::Shape::hexahedron || shape == mesh::Shape::voxel) {
    for (int a = 0; a < 3; ++a) {
      distance[2 * a] = r[a];
      distance[2 * a + 1] = 1.0 - r[a];
    }
    return 6;
  }
  double weights[8];
  shape_functions(shape, r, weights);
  const int faces = face_table(shape).face_count;
  for (int f = 0; f < faces; ++f)
    distance[f] = parametric_distance(shape, f, weights);
  return faces;
}

/// Whether a face, or where it goes on beyond the cell, is as near as this to coordinates that may
/// lie beyond other faces. At the price of a few additions.
INSITU_HD inline bool is_near_faces(mesh::Shape shape, const math::Vec3d& r, double near) {
  const auto nearest = [](double a, double b) {
    a = a < 0.0 ? -a : a;
    b = b < 0.0 ? -b : b;
    return a < b ? a : b;
  };
  double least = nearest(nearest(r.x, r.y), r.z);
  if (shape == mesh::Shape::tetrahedron)
    least = nearest(least, 1.0 - r.x - r.y - r.z);
  else if (shape == mesh::Shape::wedge)
    least = nearest(nearest(least, 1.0 - r.x - r.y), 1.0 - r.z);
  else
    least = nearest(nearest(least, 1.0 - r.x), nearest(1.0 - r.y, 1.0 - r.z));
  return least <= near;
}

/// The vertices, a bit each, of the smallest face, edge or vertex as near as this to coordinates;
/// 0: none is.
INSITU_HD inline unsigned vertices_near(mesh::Shape shape, const math::Vec3d& r, double near) {
  const ReferenceVertices at = reference_vertices(shape);
  const auto is = [near](double distance) { return distance <= near && distance >= -near; };
  unsigned on = 0xff;
  for (int a = 0; a < 3; ++a) {
    on &= is(r[a]) ? at.zero[a] : 0xff;
    on &= is(1.0 - r[a]) ? at.one[a] : 0xff;
  }
  const double sum = r.x + r.y + (shape == mesh::Shape::tetrahedron ? r.z : 0.0);
  if (at.slanted != 0 && is(1.0 - sum))
    on &= at.slanted;
  return on == 0xff ? 0 : on;
}

/// Coordinates of p in the cell with vertices x, with the error of an inverse map, put on the
/// smallest face, edge or vertex that is no further away, if they still lead to p but for rounding:
/// in a flat cell the error is that of its thin axis. What a point there that is not on a face has
/// of the vertices beside it is noise.
INSITU_HD inline math::Vec3d put_on_nearest(mesh::Shape shape, const math::Vec3d* x,
                                            const math::Vec3d& p, const math::Vec3d& r,
                                            double error) {
  constexpr double largest = 1e-9; // else all of a flat cell may be no further away
  const unsigned on = error < largest ? vertices_near(shape, r, error) : 0;
  if (on == 0)
    return r;
  constexpr double rounding = 64.0 * 0x1p-53;
  const math::Vec3d put = put_on(shape, on, r), back = map_to_physical(shape, x, put);
  for (int a = 0; a < 3; ++a) {
    double most = p[a] < 0.0 ? -p[a] : p[a];
    for (int v = 0; v < mesh::vertex_count(shape); ++v) {
      const double of_vertex = x[v][a] < 0.0 ? -x[v][a] : x[v][a];
      most = of_vertex > most ? of_vertex : most;
    }
    const double off = back[a] - p[a];
    if (!((off < 0.0 ? -off : off) <= rounding * most))
      return r;
  }
  return put;
}

/// The coordinates r, of a point p that may lie beyond the cell's faces, put on those faces as near
/// as this to r on which, or in whose planes, p lies exactly; where one of these is curved, on
/// edges in whose lines it lies, too.
math::Vec3d put_on_faces_of(mesh::Shape shape, const math::Vec3d* x, const math::Vec3d& p,
                            const math::Vec3d& r, double near);

} // namespace insitu::cells

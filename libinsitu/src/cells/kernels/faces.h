#pragma once

#include <cstdint>

#include "math/hd.h"
#include "math/vec.h"
#include "mesh/shape.h"

/// The faces and edges of the cell shapes by local vertex number, in the point order of VTK.
namespace insitu::cells {

/// The vertices of a face are in cyclic order, counterclockwise as seen from outside the cell;
/// vertex_count is 3 or 4.
struct Face {
  std::uint8_t vertex_count = 0;
  std::uint8_t vertices[4] = {};
};

struct Edge {
  std::uint8_t vertices[2] = {};
};

struct FaceTable {
  int vertex_count = 0, face_count = 0, edge_count = 0;
  Face faces[6] = {};
  Edge edges[12] = {};
};

/// Returns the table of a shape, which has no faces for Shape::none.
///
/// Outward means outward for a cell in the order that VTK documents. For the wedge that is the
/// order in which triangle 0, 1, 2 faces away from 3, 4, 5: the manual, the face table and the
/// readers of VTK have it so. The shape functions of the wedge have a negative Jacobian there,
/// which containment does not depend on.
INSITU_HD constexpr FaceTable face_table(mesh::Shape shape) {
  switch (shape) {
  case mesh::Shape::tetrahedron:
    return {4,
            4,
            6,
            {{3, {0, 1, 3}}, {3, {1, 2, 3}}, {3, {2, 0, 3}}, {3, {0, 2, 1}}},
            {{{0, 1}}, {{1, 2}}, {{2, 0}}, {{0, 3}}, {{1, 3}}, {{2, 3}}}};
  case mesh::Shape::voxel:
    return {8,
            6,
            12,
            {{4, {0, 4, 6, 2}},
             {4, {1, 3, 7, 5}},
             {4, {0, 1, 5, 4}},
             {4, {2, 6, 7, 3}},
             {4, {0, 2, 3, 1}},
             {4, {4, 5, 7, 6}}},
            {{{0, 1}},
             {{1, 3}},
             {{2, 3}},
             {{0, 2}},
             {{4, 5}},
             {{5, 7}},
             {{6, 7}},
             {{4, 6}},
             {{0, 4}},
             {{1, 5}},
             {{2, 6}},
             {{3, 7}}}};
  case mesh::Shape::hexahedron:
    return {8,
            6,
            12,
            {{4, {0, 4, 7, 3}},
             {4, {1, 2, 6, 5}},
             {4, {0, 1, 5, 4}},
             {4, {3, 7, 6, 2}},
             {4, {0, 3, 2, 1}},
             {4, {4, 5, 6, 7}}},
            {{{0, 1}},
             {{1, 2}},
             {{3, 2}},
             {{0, 3}},
             {{4, 5}},
             {{5, 6}},
             {{7, 6}},
             {{4, 7}},
             {{0, 4}},
             {{1, 5}},
             {{3, 7}},
             {{2, 6}}}};
  case mesh::Shape::wedge:
    return {
        6,
        5,
        9,
        {{3, {0, 1, 2}}, {3, {3, 5, 4}}, {4, {0, 3, 4, 1}}, {4, {1, 4, 5, 2}}, {4, {2, 5, 3, 0}}},
        {{{0, 1}}, {{1, 2}}, {{2, 0}}, {{3, 4}}, {{4, 5}}, {{5, 3}}, {{0, 3}}, {{1, 4}}, {{2, 5}}}};
  case mesh::Shape::pyramid:
    return {5,
            5,
            8,
            {{4, {0, 3, 2, 1}}, {3, {0, 1, 4}}, {3, {1, 2, 4}}, {3, {2, 3, 4}}, {3, {3, 0, 4}}},
            {{{0, 1}}, {{1, 2}}, {{2, 3}}, {{3, 0}}, {{0, 4}}, {{1, 4}}, {{2, 4}}, {{3, 4}}}};
  case mesh::Shape::none:
    break;
  }
  return {};
}

/// Returns how far a point with these weights (shape_functions) lies from a face, in parametric
/// units, negative beyond the face: the sum of the weights of the vertices that are not on the
/// face. The least distance over the faces of a cell is the margin of InverseMap.
INSITU_HD inline double parametric_distance(mesh::Shape shape, int face, const double* weights) {
  const FaceTable table = face_table(shape);
  const Face& f = table.faces[face];
  double on = 0.0;
  for (int k = 0; k < f.vertex_count; ++k)
    on += weights[f.vertices[k]];
  return 1.0 - on;
}

/// Side k of a face goes from its vertex k to the next one. `edge` is its number among the edges of
/// the shape, or -1 if it is none of them; `reversed` says that the side goes from the second
/// vertex of the edge to the first.
struct FaceSide {
  int edge = -1;
  bool reversed = false;
};
INSITU_HD constexpr FaceSide face_side(mesh::Shape shape, int face, int k) {
  const FaceTable table = face_table(shape);
  const Face& f = table.faces[face];
  const int from = f.vertices[k], to = f.vertices[(k + 1) % f.vertex_count];
  for (int e = 0; e < table.edge_count; ++e) {
    const auto& v = table.edges[e].vertices;
    if (v[0] == from && v[1] == to)
      return {e, false};
    if (v[0] == to && v[1] == from)
      return {e, true};
  }
  return {};
}

/// The four local vertices of a quad in cyclic order: p00, p10, p11, p01 of its patch.
struct Quad {
  std::uint8_t vertices[4] = {};
};

/// Returns the canonical order of a quad. It is cyclic, from the corner with the lexicographically
/// lowest (x, y, z) towards the lower of the two neighbours of that corner. Both cells that share
/// the quad get the same coordinates in the same order, and so the same diagonal p00-p11, however
/// each numbers its vertices. Corners that coincide may leave two orders to choose from; both give
/// the same triangles, or triangles that differ only by ones without area.
template <class T>
INSITU_HD constexpr Quad canonical_order(const Face& quad, const math::Vec3<T>* vertices) {
  const auto lower = [vertices](std::uint8_t i, std::uint8_t j) {
    const math::Vec3<T>&a = vertices[i], &b = vertices[j];
    if (a.x != b.x)
      return a.x < b.x;
    if (a.y != b.y)
      return a.y < b.y;
    return a.z < b.z;
  };
  int first = 0;
  for (int i = 1; i < 4; ++i) {
    if (lower(quad.vertices[i], quad.vertices[first]))
      first = i;
  }
  const std::uint8_t next = quad.vertices[(first + 1) & 3];
  const std::uint8_t previous = quad.vertices[(first + 3) & 3];
  const std::uint8_t opposite = quad.vertices[(first + 2) & 3];
  if (lower(previous, next))
    return {{quad.vertices[first], previous, opposite, next}};
  return {{quad.vertices[first], next, opposite, previous}};
}

} // namespace insitu::cells

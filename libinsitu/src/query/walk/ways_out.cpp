#include "query/walk/ways_out.h"

#include <algorithm>

#include "cells/exact/decide.h"
#include "cells/kernels/kernels.h"

namespace insitu::query {

using cells::Crossing;
using math::Vec3d;

namespace {

Vec3d unit_normal(const Vec3d& a, const Vec3d& b) {
  return unit(cross(a / std::max(largest(a), std::numeric_limits<double>::min()),
                    b / std::max(largest(b), std::numeric_limits<double>::min())));
}

/// The point of a face with these weights of its corners, and the normal there, out of the cell.
FacePoint on_face(const mesh::CellVertices& c, int count, const std::uint8_t* corners,
                  const double* weights) {
  Vec3d x[4], face_centre, centre;
  for (int k = 0; k < count; ++k)
    x[k] = c.x[corners[k]] - c.x[corners[0]];
  FacePoint out;
  for (int k = 1; k < count; ++k) {
    out.point += weights[k] * x[k];
    face_centre += (1.0 / count) * x[k];
  }
  if (count == 3) {
    out.normal = unit_normal(x[1], x[2]);
  } else {
    const double u = weights[1] + weights[2], v = weights[2] + weights[3];
    out.normal =
        unit_normal((1 - v) * x[1] + v * (x[2] - x[3]), (1 - u) * x[3] + u * (x[2] - x[1]));
    if (out.normal == Vec3d{}) // at a corner that is drawn out to a point or folded back
      out.normal = unit_normal(x[2], x[3] - x[1]);
  }
  // Cells may be turned over, and the order of a wedge is not always VTK's.
  for (int i = 0; i < c.count; ++i)
    centre += (1.0 / c.count) * (c.x[i] - c.x[corners[0]]);
  if (dot(out.normal, face_centre - centre) < 0.0)
    out.normal = -out.normal;
  out.point += c.x[corners[0]];
  return out;
}

/// The face whose corners these are (all, or those that are left of a collapsed quad).
int face_of(mesh::Shape shape, const Crossing& crossing) {
  const cells::FaceTable table = cells::face_table(shape);
  for (int f = 0; f < table.face_count; ++f) {
    const cells::Face& face = table.faces[f];
    const std::uint8_t* end = face.vertices + face.vertex_count;
    if (std::all_of(crossing.vertices, crossing.vertices + crossing.count,
                    [&](std::uint8_t v) { return std::find(face.vertices, end, v) != end; }))
      return f;
  }
  return -1;
}

WayOut make(const mesh::CellVertices& c, std::int64_t flat, int face, double t, int count,
            const std::uint8_t* corners, const double* weights) {
  const FacePoint p = on_face(c, count, corners, weights);
  constexpr double part = 1.0 / 1024;
  double within[4];
  for (int k = 0; k < count; ++k)
    within[k] = (1.0 - part) * weights[k] + part / count;
  return {{t, p.point, flat, face, p.normal}, on_face(c, count, corners, within)};
}

/// How far a cell reaches from a point: what rounding of distances in it is measured by.
double reach(const mesh::CellVertices& c, const Vec3d& a) {
  double far = 0.0;
  for (int i = 0; i < c.count; ++i)
    far = std::max(far, largest(c.x[i] - a));
  return far;
}

} // namespace

double largest(const Vec3d& v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

double largest_coordinate(const mesh::CellVertices& c) {
  double most = 0.0;
  for (int i = 0; i < c.count; ++i)
    most = std::max(most, largest(c.x[i]));
  return most;
}

Vec3d unit(Vec3d v) {
  const double scale = largest(v);
  if (!(scale > 0.0) || !std::isfinite(scale))
    return {};
  v = v / scale;
  return v / std::sqrt(dot(v, v));
}

Segment::Segment(const Vec3d& from, const Vec3d& to)
    : a(from), b(to), direction(unit(to - from)),
      length(std::hypot(to.x - from.x, to.y - from.y, to.z - from.z)), space({a, direction}) {}

WaysOut ways_out(const mesh::CellVertices& c, std::int64_t flat, const Segment& s, double from) {
  WaysOut out;
  Crossing crossings[cells::most_crossings];
  const int n = cells::face_crossings(c, s.space, crossings);
  if (n == 0)
    return out;
  const double tolerance = 32.0 * epsilon * reach(c, s.a);
  // Cells whose faces are curved can be left and entered again.
  int last = n - 1;
  for (int k = 0; k + 1 < n && n > 2; ++k) {
    const double begin = std::max(crossings[k].t, from), end = crossings[k + 1].t;
    if (end - begin > tolerance &&
        !cells::holds(cells::contain_exact(c.shape, c.x, s.at(0.5 * (begin + end))).where) &&
        crossings[k].t >= from - tolerance) {
      last = k;
      break;
    }
  }
  out.distance = std::max(crossings[last].t, from);
  for (int k = 0; k < n; ++k)
    if (std::abs(crossings[k].t - crossings[last].t) <= tolerance)
      out.faces[out.count++] =
          make(c, flat, face_of(c.shape, crossings[k]), std::min(out.distance / s.length, 1.0),
               crossings[k].count, crossings[k].vertices, crossings[k].weights);
  // The one that faces the segment most comes first.
  std::stable_sort(out.faces, out.faces + out.count, [&](const WayOut& a, const WayOut& b) {
    return dot(a.normal, s.direction) > dot(b.normal, s.direction);
  });
  return out;
}

WayOut on_parametric_face(const mesh::CellVertices& c, std::int64_t flat, int face, const double* n,
                          double t) {
  const cells::Face f = cells::face_table(c.shape).faces[face];
  double weights[4], sum = 0.0;
  for (int k = 0; k < f.vertex_count; ++k)
    sum += weights[k] = std::clamp(n[f.vertices[k]], 0.0, 1.0);
  for (int k = 0; k < f.vertex_count; ++k)
    weights[k] = sum > 0.0 ? weights[k] / sum : 1.0 / f.vertex_count;
  return make(c, flat, face, t, f.vertex_count, f.vertices, weights);
}

FaceCrossing nearest_face(const mesh::CellVertices& vertices, std::int64_t cell,
                          const Vec3d& parametric) {
  double n[8];
  cells::shape_functions(vertices.shape, parametric, n);
  int nearest = 0;
  for (int f = 1; f < cells::face_table(vertices.shape).face_count; ++f)
    if (cells::parametric_distance(vertices.shape, f, n) <
        cells::parametric_distance(vertices.shape, nearest, n))
      nearest = f;
  return on_parametric_face(vertices, cell, nearest, n, 0.0);
}

} // namespace insitu::query

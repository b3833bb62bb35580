#include "workload/queries.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"
#include "core/random.h"
#include "math/morton.h"

namespace insitu::workload {

namespace {

using math::Vec3d;
using mesh::Shape;

struct Bounds {
  Vec3d lo{1e300, 1e300, 1e300}, hi{-1e300, -1e300, -1e300};
  void add(const Vec3d& p) {
    for (int a = 0; a < 3; ++a) {
      lo[a] = std::min(lo[a], p[a]);
      hi[a] = std::max(hi[a], p[a]);
    }
  }
};

Queries uniform(const Mesh& mesh) {
  Queries q;
  const std::int64_t n = mesh.cell_count();
  q.points.resize(std::size_t(n));
  q.made_in.resize(std::size_t(n));
  for (std::int64_t c = 0; c < n; ++c) {
    Vec3d x[8], sum;
    std::int64_t vertices = 0;
    if (mesh.has_faces()) { // a vertex of these lies on three faces
      for (std::int64_t k = mesh.cell_offsets[std::size_t(c)];
           k < mesh.cell_offsets[std::size_t(c) + 1]; ++k) {
        const auto f = std::size_t(mesh.cell_faces[std::size_t(k)]);
        for (std::int64_t v = mesh.face_offsets[f]; v < mesh.face_offsets[f + 1]; ++v, ++vertices)
          sum += mesh.point(mesh.face_vertices[std::size_t(v)]);
      }
    } else {
      vertices = mesh.gather(c, x);
      for (int v = 0; v < vertices; ++v)
        sum += x[v];
    }
    q.points[std::size_t(c)] = sum / double(vertices);
    q.made_in[std::size_t(c)] = std::int32_t(c);
  }
  return q;
}

/// Where polyhedra leave no gaps.
Queries random_in_middle(const Mesh& mesh, std::int64_t count) {
  Queries q;
  const double margin = 0.75 * mesh.cell_size;
  for (std::uint64_t i = 0; i < std::uint64_t(count); ++i) {
    Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = margin + (1.0 - 2.0 * margin) * core::random_unit(2, i, std::uint64_t(1 + a));
    q.points.push_back(p);
  }
  return q;
}

Queries random(const Mesh& mesh, std::int64_t count) {
  if (mesh.has_faces())
    return random_in_middle(mesh, count);
  Queries q;
  const auto cells = std::uint64_t(mesh.cell_count());
  q.points.resize(std::size_t(count));
  q.made_in.resize(std::size_t(count));
  for (std::size_t i = 0; i < q.points.size(); ++i) {
    const auto cell = std::int64_t(core::random_bits(2, i, 0) % cells);
    Vec3d x[8], p;
    const int vertices = mesh.gather(cell, x);
    double weights[8] = {};
    cells::shape_functions(mesh.shape(cell), random_parametric(mesh.shape(cell), i), weights);
    for (int v = 0; v < vertices; ++v)
      p += weights[v] * x[v];
    q.points[i] = p;
    q.made_in[i] = std::int32_t(cell);
  }
  return q;
}

Queries in_morton_order(const Queries& from) {
  Queries q;
  q.points.reserve(from.points.size());
  q.made_in.reserve(from.points.size());
  for (const std::uint32_t i : morton_order(from.points)) {
    q.points.push_back(from.points[i]);
    if (!from.made_in.empty())
      q.made_in.push_back(from.made_in[i]);
  }
  return q;
}

Vec3d unit(const Vec3d& a) {
  return a / std::sqrt(dot(a, a));
}

/// The camera of the standard volume frame, scaled to the mesh's box.
Queries march(const Mesh& mesh, std::int64_t count) {
  constexpr int side = 512;
  const double half_height = std::tan(0.5 * 35.0 * 3.14159265358979323846 / 180.0);
  const Vec3d eye{1.6, 1.3, 2.2}, target{0.5, 0.5, 0.5};
  const Vec3d forward = unit(target - eye), right = unit(cross(forward, Vec3d{0.0, 1.0, 0.0})),
              up = cross(right, forward);
  Bounds box;
  for (std::int64_t v = 0; v < mesh.vertex_count(); ++v)
    box.add(mesh.point(v));
  const Vec3d extent = box.hi - box.lo;
  const double largest = std::max(extent.x, std::max(extent.y, extent.z));
  const double step = 0.5 * mesh.cell_size / (largest > 0.0 ? largest : 1.0);
  Queries q;
  q.points.reserve(std::size_t(count));
  for (int row = 0; row < side && std::int64_t(q.points.size()) < count; ++row) {
    const int j = (row + side / 2) % side;
    for (int i = 0; i < side && std::int64_t(q.points.size()) < count; ++i) {
      const Vec3d d = unit(forward + (2.0 * (i + 0.5) / side - 1.0) * half_height * right +
                           (1.0 - 2.0 * (j + 0.5) / side) * half_height * up);
      double enter = 0.0, leave = std::numeric_limits<double>::infinity();
      for (int a = 0; a < 3; ++a) {
        const double t0 = (0.0 - eye[a]) / d[a], t1 = (1.0 - eye[a]) / d[a];
        enter = std::max(enter, std::min(t0, t1));
        leave = std::min(leave, std::max(t0, t1));
      }
      // The margin keeps rounding from putting a last point outside the box.
      for (int s = 0; std::int64_t(q.points.size()) < count; ++s) {
        const double t = enter + (s + 0.5) * step;
        if (!(t < leave - 1e-3 * step))
          break;
        const Vec3d p = eye + t * d;
        q.points.push_back(box.lo + Vec3d{p.x * extent.x, p.y * extent.y, p.z * extent.z});
      }
    }
  }
  return q;
}

Queries on_boundary(const Mesh& mesh, Pattern feature, std::int64_t count) {
  Queries q;
  const std::uint64_t seed = feature == Pattern::vertices ? 3 : feature == Pattern::edges ? 4 : 5;
  const auto cells = std::uint64_t(mesh.cell_count());
  for (std::uint64_t i = 0; cells > 0 && i < std::uint64_t(count); ++i) {
    const auto cell = std::int64_t(core::random_bits(seed, i, 0) % cells);
    Vec3d x[8], p;
    const int vertices = mesh.gather(cell, x);
    const cells::FaceTable table = cells::face_table(mesh.shape(cell));
    const std::uint64_t pick = core::random_bits(seed, i, 1);
    double u = core::random_unit(seed, i, 2), v = core::random_unit(seed, i, 3);
    if (feature == Pattern::vertices) {
      p = x[pick % std::uint64_t(vertices)];
    } else if (feature == Pattern::edges) {
      const cells::Edge& e = table.edges[pick % std::uint64_t(table.edge_count)];
      p = (1.0 - u) * x[e.vertices[0]] + u * x[e.vertices[1]];
    } else {
      const cells::Face& f = table.faces[pick % std::uint64_t(table.face_count)];
      const Vec3d &a = x[f.vertices[0]], &b = x[f.vertices[1]], &c = x[f.vertices[2]];
      if (f.vertex_count == 4) {
        p = (1.0 - u) * (1.0 - v) * a + u * (1.0 - v) * b + u * v * c +
            (1.0 - u) * v * x[f.vertices[3]];
      } else {
        if (u + v > 1.0) {
          u = 1.0 - u;
          v = 1.0 - v;
        }
        p = (1.0 - u - v) * a + u * b + v * c;
      }
    }
    q.points.push_back(p);
    q.made_in.push_back(std::int32_t(cell));
  }
  return q;
}

} // namespace

std::vector<std::uint32_t> morton_order(std::span<const Vec3d> points) {
  Bounds box;
  for (const Vec3d& p : points)
    box.add(p);
  constexpr int index_bits = 31;
  constexpr double steps = 1 << 11;
  double scale[3];
  for (int a = 0; a < 3; ++a)
    scale[a] = box.hi[a] > box.lo[a] ? steps / (box.hi[a] - box.lo[a]) : 0.0;
  std::vector<std::uint64_t> keys(points.size());
  for (std::size_t i = 0; i < keys.size(); ++i) {
    std::uint64_t code = 0;
    for (int a = 0; a < 3; ++a) {
      const double step = std::min((points[i][a] - box.lo[a]) * scale[a], steps - 1.0);
      code |= math::spread_bits(std::uint64_t(step)) << a;
    }
    keys[i] = code << index_bits | i;
  }
  std::sort(keys.begin(), keys.end());
  std::vector<std::uint32_t> order(points.size());
  for (std::size_t i = 0; i < order.size(); ++i)
    order[i] = std::uint32_t(keys[i] & ((1u << index_bits) - 1));
  return order;
}

const char* name(Pattern pattern) {
  constexpr const char* names[] = {"uniform",  "random", "sorted", "march",
                                   "vertices", "edges",  "faces"};
  return names[int(pattern)];
}

std::optional<Pattern> pattern_from_name(std::string_view text) {
  for (int p = 0; p < 7; ++p)
    if (text == name(Pattern(p)))
      return Pattern(p);
  return std::nullopt;
}

Vec3d random_parametric(Shape shape, std::uint64_t i) {
  double u[3] = {core::random_unit(2, i, 1), core::random_unit(2, i, 2),
                 core::random_unit(2, i, 3)};
  if (shape == Shape::wedge && u[0] + u[1] > 1.0) {
    u[0] = 1.0 - u[0];
    u[1] = 1.0 - u[1];
  }
  if (shape == Shape::tetrahedron) { // the gaps of sorted numbers are uniform in the simplex
    std::sort(u, u + 3);
    return {u[1] - u[0], u[2] - u[1], 1.0 - u[2]};
  }
  return {u[0], u[1], u[2]};
}

Queries make_queries(const Mesh& mesh, Pattern pattern, std::int64_t count) {
  if (mesh.cell_count() == 0)
    return {};
  switch (pattern) {
  case Pattern::uniform:
    return uniform(mesh);
  case Pattern::random:
    return random(mesh, count);
  case Pattern::sorted:
    return in_morton_order(random(mesh, count));
  case Pattern::march:
    return march(mesh, count);
  case Pattern::vertices:
  case Pattern::edges:
  case Pattern::faces:
    break;
  }
  return on_boundary(mesh, pattern, count);
}

} // namespace insitu::workload

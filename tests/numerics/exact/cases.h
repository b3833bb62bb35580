#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <random>
#include <string>
#include <vector>

#include "cells/kernels/faces.h"
#include "math/vec.h"
#include "mesh/shape.h"

/// Cells, conforming meshes and points that try to break containment.
namespace insitu::test {

using math::Vec3d;
using mesh::Shape;

inline constexpr Shape all_shapes[] = {Shape::tetrahedron, Shape::voxel, Shape::hexahedron,
                                       Shape::wedge, Shape::pyramid};

class Random {
public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  std::uint64_t bits() { return engine_(); }
  int below(int n) { return static_cast<int>(engine_() % static_cast<std::uint64_t>(n)); }
  double uniform(double low, double high) {
    return low + (high - low) * (static_cast<double>(engine_() >> 11) * 0x1p-53);
  }
  Vec3d uniform(const Vec3d& low, const Vec3d& high) {
    const double x = uniform(low.x, high.x), y = uniform(low.y, high.y);
    return {x, y, uniform(low.z, high.z)};
  }

private:
  std::mt19937_64 engine_;
};

using Vertices = std::array<Vec3d, 8>;

/// The shape in the unit cube, outward as in face_table.
inline Vertices unit_cell(Shape shape) {
  switch (shape) {
  case Shape::tetrahedron:
    return {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  case Shape::voxel:
    return {
        {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {1, 1, 1}}};
  case Shape::hexahedron:
    return {
        {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {0, 1, 1}}};
  case Shape::wedge:
    return {{{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {0, 0, 1}, {0, 1, 1}, {1, 0, 1}}};
  case Shape::pyramid:
    return {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0.5, 0.5, 1}}};
  case Shape::none:
    break;
  }
  return {};
}

struct Bounds {
  Vec3d low, high;
  bool holds(const Vec3d& p) const {
    return p.x >= low.x && p.x <= high.x && p.y >= low.y && p.y <= high.y && p.z >= low.z &&
           p.z <= high.z;
  }
};
inline Bounds bounds_of(Shape shape, const Vec3d* vertices) {
  Bounds b{vertices[0], vertices[0]};
  for (int i = 1; i < mesh::vertex_count(shape); ++i)
    for (int axis = 0; axis < 3; ++axis) {
      b.low[axis] = std::fmin(b.low[axis], vertices[i][axis]);
      b.high[axis] = std::fmax(b.high[axis], vertices[i][axis]);
    }
  return b;
}

/// The point of a face at (u, v), as rounding leaves it.
inline Vec3d face_point(const cells::Face& face, const Vec3d* vertices, double u, double v) {
  const auto& f = face.vertices;
  if (face.vertex_count == 3) {
    return (1 - u - v) * vertices[f[0]] + u * vertices[f[1]] + v * vertices[f[2]];
  }
  return ((1 - u) * (1 - v)) * vertices[f[0]] + (u * (1 - v)) * vertices[f[1]] +
         (u * v) * vertices[f[2]] + ((1 - u) * v) * vertices[f[3]];
}

/// Moves one coordinate to a neighbouring double; up to `ulps` times.
inline Vec3d nudge(Vec3d p, Random& random, int ulps) {
  double& x = p[random.below(3)];
  const double target = random.below(2) == 0 ? -HUGE_VAL : HUGE_VAL;
  for (int i = random.below(ulps + 1); i > 0; --i)
    x = std::nextafter(x, target);
  return p;
}

/// One of the points that matter to a cell: near and on its faces, diagonals, edges, vertices,
/// level with its vertices (where a ray along x meets them), anywhere in its box.
inline Vec3d adversarial_point(Shape shape, const Vec3d* vertices, Random& random, bool dyadic) {
  const cells::FaceTable table = cells::face_table(shape);
  const auto fraction = [&] { return dyadic ? random.below(9) / 8.0 : random.uniform(0.0, 1.0); };
  const cells::Face& face = table.faces[random.below(table.face_count)];
  const auto [low, high] = bounds_of(shape, vertices);
  Vec3d mean{};
  for (int i = 0; i < table.vertex_count; ++i)
    mean += vertices[i] / static_cast<double>(table.vertex_count);
  switch (random.below(8)) {
  case 0: {
    const double u = fraction(), v = fraction() * (face.vertex_count == 3 ? 1 - u : 1);
    return nudge(face_point(face, vertices, u, v), random, 2);
  }
  case 1: {
    const double u = fraction(), v = fraction() * (face.vertex_count == 3 ? 1 - u : 1);
    return face_point(face, vertices, u, v);
  }
  case 2: { // on a diagonal or one of the two triangulations
    const Vec3d a = vertices[face.vertices[0]], b = vertices[face.vertices[1]],
                c = vertices[face.vertices[2]], d = vertices[face.vertices[face.vertex_count - 1]];
    const double t = fraction(), s = fraction();
    const Vec3d diagonal = random.below(2) == 0 ? (1 - t) * a + t * c : (1 - t) * b + t * d;
    const Vec3d corner = vertices[face.vertices[random.below(face.vertex_count)]];
    return nudge(random.below(2) == 0 ? diagonal : (1 - s) * diagonal + s * corner, random, 1);
  }
  case 3: {
    const auto& e = table.edges[random.below(table.edge_count)].vertices;
    const double t = fraction();
    return nudge((1 - t) * vertices[e[0]] + t * vertices[e[1]], random, 1);
  }
  case 4:
    return nudge(vertices[random.below(table.vertex_count)], random, 1);
  case 5: { // level with vertices
    Vec3d p = dyadic ? mean : random.uniform(low, high);
    for (int axis = 0; axis < 3; ++axis) {
      if (random.below(3) != 0)
        p[axis] = vertices[random.below(table.vertex_count)][axis];
    }
    return p;
  }
  case 6:
    return mean;
  default:
    return random.uniform(low, high);
  }
}

inline std::string describe(Shape shape, const Vec3d* vertices, const Vec3d& point) {
  char line[160];
  std::string text = std::string(mesh::shape_name(shape)) + "\n";
  const auto add = [&](const char* name, const Vec3d& p) {
    std::snprintf(line, sizeof line, "  %s {%a, %a, %a}\n", name, p.x, p.y, p.z);
    text += line;
  };
  for (int i = 0; i < mesh::vertex_count(shape); ++i)
    add("vertex", vertices[i]);
  add("point", point);
  return text;
}

struct MeshCell {
  Shape shape;
  std::array<int, 8> vertices;
};

struct TestMesh {
  Vec3d low, high; // the box that it fills
  std::vector<Vec3d> vertices;
  std::vector<MeshCell> cells;

  Vertices cell_vertices(const MeshCell& cell) const {
    Vertices result{};
    for (int i = 0; i < mesh::vertex_count(cell.shape); ++i) {
      result[i] = vertices[cell.vertices[i]];
    }
    return result;
  }
};

enum class MeshKind { hexahedra, voxels, wedges, pyramids, tetrahedra, mixed };

struct MeshOptions {
  MeshKind kind = MeshKind::hexahedra;
  int size = 4;          // blocks along each axis
  double jitter = 0.25;  // of interior vertices, in spacings
  double offset = 0.0;   // added to every coordinate
  Vec3d scale{1, 1, 1};  // of the spacing along each axis
  double snap = 0.0;     // coordinates are multiples of it, if not 0
  double collapse = 0.0; // share of the interior vertices moved onto a neighbour
};

TestMesh make_mesh(const MeshOptions& options, Random& random);
inline TestMesh make_mesh(const MeshOptions& options, std::uint64_t seed) {
  Random random(seed);
  return make_mesh(options, random);
}

} // namespace insitu::test

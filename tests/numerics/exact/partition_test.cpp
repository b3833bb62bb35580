/// One owner: on a conforming mesh every point is strictly inside exactly one cell, or on the same
/// kind of boundary of every cell that holds it.

#include <gtest/gtest.h>

#include "cases.h"
#include "cells/exact/contain_exact.h"

namespace insitu::test {
namespace {

using cells::Containment;

constexpr MeshKind all_kinds[] = {MeshKind::hexahedra, MeshKind::voxels,     MeshKind::wedges,
                                  MeshKind::pyramids,  MeshKind::tetrahedra, MeshKind::mixed};

struct Owners {
  int inside = 0, on_face = 0, on_edge = 0, on_vertex = 0;
  int all() const { return inside + on_face + on_edge + on_vertex; }
};

Owners owners(const TestMesh& mesh, const Vec3d& point) {
  Owners result;
  for (const MeshCell& cell : mesh.cells) {
    const Vertices v = mesh.cell_vertices(cell);
    switch (cells::contain_exact(cell.shape, v.data(), point).where) {
    case Containment::outside:
      break;
    case Containment::inside:
      ++result.inside;
      break;
    case Containment::on_face:
      ++result.on_face;
      break;
    case Containment::on_edge:
      ++result.on_edge;
      break;
    case Containment::on_vertex:
      ++result.on_vertex;
      break;
    }
  }
  return result;
}

bool in_box(const TestMesh& mesh, const Vec3d& p) {
  return p.x >= mesh.low.x && p.x <= mesh.high.x && p.y >= mesh.low.y && p.y <= mesh.high.y &&
         p.z >= mesh.low.z && p.z <= mesh.high.z;
}
bool on_box(const TestMesh& mesh, const Vec3d& p) {
  return in_box(mesh, p) && (p.x == mesh.low.x || p.x == mesh.high.x || p.y == mesh.low.y ||
                             p.y == mesh.high.y || p.z == mesh.low.z || p.z == mesh.high.z);
}

std::string describe(const Owners& o, const Vec3d& p) {
  char text[160];
  std::snprintf(text, sizeof text, "point {%a, %a, %a}: inside %d, on face %d, edge %d, vertex %d",
                p.x, p.y, p.z, o.inside, o.on_face, o.on_edge, o.on_vertex);
  return text;
}

/// A valid mesh: one owner, and agreement about what kind of point it is.
void check_valid(const TestMesh& mesh, const Vec3d& p) {
  const Owners o = owners(mesh, p);
  if (!in_box(mesh, p)) {
    ASSERT_EQ(o.all(), 0) << describe(o, p);
    return;
  }
  ASSERT_GE(o.all(), 1) << describe(o, p);
  const int kinds = (o.inside > 0) + (o.on_face > 0) + (o.on_edge > 0) + (o.on_vertex > 0);
  ASSERT_EQ(kinds, 1) << describe(o, p);
  if (o.inside > 0) {
    ASSERT_EQ(o.inside, 1) << describe(o, p);
  }
  if (o.on_face > 0) {
    ASSERT_EQ(o.on_face, on_box(mesh, p) ? 1 : 2) << describe(o, p);
  }
}

/// Any conforming mesh, tangled or collapsed: the boundaries cancel in pairs, so a point off them
/// all is inside an odd number of cells within the box, and an even number outside.
void check_parity(const TestMesh& mesh, const Vec3d& p) {
  const Owners o = owners(mesh, p);
  if (o.all() != o.inside)
    return;
  ASSERT_EQ(o.inside % 2 != 0, in_box(mesh, p)) << describe(o, p);
}

void run(MeshOptions options, std::uint64_t seed, int points_per_mesh, bool valid) {
  for (MeshKind kind : all_kinds) {
    options.kind = kind;
    SCOPED_TRACE("seed " + std::to_string(seed) + ", mesh kind " +
                 std::to_string(static_cast<int>(kind)));
    Random random(seed);
    const TestMesh mesh = make_mesh(options, random);
    for (int i = 0; i < points_per_mesh; ++i) {
      const MeshCell& cell = mesh.cells[random.below(static_cast<int>(mesh.cells.size()))];
      const Vertices v = mesh.cell_vertices(cell);
      const Vec3d p = adversarial_point(cell.shape, v.data(), random, options.snap > 0);
      valid ? check_valid(mesh, p) : check_parity(mesh, p);
      if (testing::Test::HasFatalFailure())
        return;
    }
  }
}

TEST(Partition, Aligned) {
  run({.jitter = 0.0}, 301, 3000, true);
}
TEST(Partition, Jittered) {
  run({.jitter = 0.2}, 302, 6000, true);
}
TEST(Partition, JitteredDyadic) {
  run({.jitter = 0.2, .snap = 0x1p-5}, 303, 6000, true);
}
TEST(Partition, Offset) {
  run({.jitter = 0.2, .offset = 1e7}, 304, 4000, true);
}
TEST(Partition, Anisotropic) {
  run({.jitter = 0.2, .scale = {1, 1, 1e-6}}, 305, 4000, true);
}
TEST(Partition, AnisotropicOffset) {
  run({.jitter = 0.2, .offset = 1e7, .scale = {1e6, 1e3, 1}}, 306, 4000, true);
}
TEST(Partition, NearlyFlat) {
  run({.jitter = 1e-15}, 307, 4000, true);
}
TEST(Partition, Collapsed) {
  run({.jitter = 0.2, .snap = 0x1p-5, .collapse = 0.3}, 308, 4000, false);
}
TEST(Partition, Tangled) {
  run({.jitter = 1.5}, 309, 4000, false);
}
TEST(Partition, TangledDyadic) {
  run({.jitter = 1.5, .snap = 0x1p-3}, 310, 6000, false);
}

} // namespace
} // namespace insitu::test

// The builder in Morton order: hard distributions of cells, and what its trees are worth.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "check_tree.h"
#include "core/random.h"
#include "fixtures/committed.h"

using namespace insitu;
using accel::Builder;
using accel::check_tree;
using accel::Node;
using accel::Tree;
using math::Vec3d;

namespace {

test::TestMesh box(test::MeshKind kind, int size) {
  return test::make_mesh({.kind = kind, .size = size}, 71);
}

/// Arrays of one tetrahedron per entry, each with four vertices of its own.
fixtures::SolverArrays tetrahedra(const std::vector<Vec3d>& centres,
                                  const std::vector<double>& sizes) {
  fixtures::SolverArrays out;
  for (std::size_t i = 0; i < centres.size(); ++i) {
    const Vec3d& c = centres[i];
    const double h = sizes[i];
    out.offsets.push_back(std::int64_t(4 * i));
    out.types.push_back(10);
    for (int v = 0; v < 4; ++v) {
      out.ids.push_back(std::int32_t(4 * i) + v);
      for (int a = 0; a < 3; ++a)
        out.points.push_back(c[a] + (a == v - 1 ? h : 0.0));
    }
  }
  out.offsets.push_back(std::int64_t(4 * centres.size()));
  return out;
}

/// Registers the arrays; the tree is the caller's.
void give(commit::CommittedMesh& mesh, std::int32_t piece, const fixtures::SolverArrays& arrays) {
  const insitu_array points = arrays.point_array();
  const insitu_cells cells = arrays.cells();
  mesh.mesh().set_points(piece, &points, 1);
  mesh.mesh().set_cells(piece, &cells);
  mesh.mesh().update();
}

bool same_bytes(const Tree& a, const Tree& b) {
  return a.node_count() == b.node_count() && a.cell_count() == b.cell_count() &&
         a.levels() == b.levels() && a.cost() == b.cost() &&
         std::memcmp(a.nodes(), b.nodes(), sizeof(Node) * a.node_count()) == 0 &&
         std::memcmp(a.cells(), b.cells(), 4 * std::size_t(a.cell_count())) == 0;
}

/// Checks the tree on one thread and on more, bytewise; returns how many levels it has.
std::size_t check_builds(const fixtures::SolverArrays& arrays) {
  core::Memory memory;
  commit::CommittedMesh mesh("m", memory);
  give(mesh, 0, arrays);
  const mesh::MeshView& view = mesh.mesh().view();
  Tree one(memory), more(memory);
  one.build(view, core::Threads(1), Builder::morton);
  check_tree(one, view);
  EXPECT_LE(one.levels().size(), 64u); // what traversals have stacks for
  for (const int threads : {2, 4}) {
    more.build(view, core::Threads(threads), Builder::morton);
    EXPECT_TRUE(same_bytes(one, more)) << threads << " threads";
  }
  const std::int64_t before = memory.current();
  more.build(view, core::Threads(1), Builder::morton); // into memory that it has used before
  EXPECT_TRUE(same_bytes(one, more));
  EXPECT_EQ(memory.current(), before);
  return one.levels().size() - 1;
}

double unit(std::size_t i, std::uint64_t channel) {
  return core::random_unit(72, i, channel);
}

double visits(const Tree& tree, const std::vector<Vec3d>& points) {
  std::int64_t visited = 0;
  for (const Vec3d& p : points) {
    std::vector<std::uint32_t> stack{0};
    while (!stack.empty()) {
      const Node& node = tree.nodes()[stack.back()];
      stack.pop_back();
      ++visited;
      for (int c = 0; c < 8; ++c) {
        if (!node.is_inner(c))
          continue;
        const accel::Box b = node.child_box(c);
        bool in = true;
        for (int a = 0; a < 3; ++a) {
          const double x = p[a] - tree.origin()[a];
          in = in && b.lower[a] <= x && x <= b.upper[a];
        }
        if (in)
          stack.push_back(node.child_node(c));
      }
    }
  }
  return double(visited) / double(points.size());
}

} // namespace

TEST(Morton, AnyCountOfCells) {
  for (const std::size_t count :
       {1u, 2u, 7u, 8u, 9u, 10u, 15u, 16u, 17u, 63u, 64u, 65u, 100u, 1000u, 100000u}) {
    std::vector<Vec3d> centres;
    for (std::size_t i = 0; i < count; ++i)
      centres.push_back({unit(i, 0), unit(i, 1), unit(i, 2)});
    check_builds(tetrahedra(centres, std::vector<double>(count, 0.01)));
  }
}

TEST(Morton, AllCentresInOnePlaceFillNodesToTheBrim) {
  for (const std::size_t count : {9u, 64u, 65u, 4096u, 5000u}) {
    const auto arrays = tetrahedra(std::vector<Vec3d>(count, Vec3d{0.3, 0.4, 0.5}),
                                   std::vector<double>(count, 1.0));
    const std::size_t levels = check_builds(arrays);
    EXPECT_LE(levels, 1 + std::size_t(std::ceil(std::log(double(count)) / std::log(8.0))));
  }
}

TEST(Morton, ManyCellsInFewPlaces) {
  std::vector<Vec3d> centres;
  for (std::size_t i = 0; i < 20000; ++i)
    centres.push_back({0.25 * std::floor(3 * unit(i, 0)), 0.5, 0.1 * std::floor(2 * unit(i, 1))});
  check_builds(tetrahedra(centres, std::vector<double>(centres.size(), 0.01)));
}

TEST(Morton, AlongALine) {
  std::vector<Vec3d> centres;
  for (std::size_t i = 0; i < 30000; ++i)
    centres.push_back({double(i), 0.0, 0.0});
  check_builds(tetrahedra(centres, std::vector<double>(centres.size(), 0.5)));
}

// Splits take off a cell or few: without the bound on levels by code, the second is deeper.
TEST(Morton, GradedByPowersStaysShallow) {
  for (const double ratio : {1.3, 2.0, 4.0}) {
    std::vector<Vec3d> centres;
    std::vector<double> sizes;
    for (double x = 1e-35; x < 1e35; x *= ratio)
      for (const Vec3d& axis : {Vec3d{1, 0, 0}, Vec3d{0, 1, 0}, Vec3d{0, 0, 1}}) {
        centres.push_back(x * axis);
        sizes.push_back(x * 0.1);
      }
    EXPECT_LE(check_builds(tetrahedra(centres, sizes)), 36u) << ratio;
  }
}

TEST(Morton, GradedMeshes) {
  for (const double grade : {1e4, 1e8}) {
    test::TestMesh mesh = box(test::MeshKind::hexahedra, 24);
    const Vec3d low = mesh.low, high = mesh.high;
    for (Vec3d& p : mesh.vertices)
      for (int a = 0; a < 3; ++a)
        p[a] = (std::pow(grade, (p[a] - low[a]) / (high[a] - low[a])) - 1.0) / (grade - 1.0);
    EXPECT_LE(check_builds(fixtures::SolverArrays(mesh)), 12u);
  }
}

TEST(Morton, EveryShape) {
  for (const auto kind :
       {test::MeshKind::hexahedra, test::MeshKind::voxels, test::MeshKind::wedges,
        test::MeshKind::pyramids, test::MeshKind::tetrahedra, test::MeshKind::mixed})
    check_builds(fixtures::SolverArrays(box(kind, 13)));
}

TEST(Morton, SeveralPiecesAndGhosts) {
  core::Memory memory;
  commit::CommittedMesh mesh("m", memory);
  const fixtures::SolverArrays hexahedra(box(test::MeshKind::hexahedra, 9)),
      mixed(box(test::MeshKind::mixed, 8));
  give(mesh, 0, hexahedra);
  give(mesh, 1, mixed);
  give(mesh, 2, hexahedra);
  std::vector<std::uint8_t> ghosts(std::size_t(mixed.cell_count()));
  for (std::size_t i = 0; i < ghosts.size(); ++i)
    ghosts[i] = unit(i, 5) < 0.4 ? 1 : 0;
  const insitu_array bits = insitu_array_of(ghosts.data(), INSITU_UINT8, mixed.cell_count(), 1);
  mesh.mesh().set_ghosts(1, &bits, INSITU_GHOSTS_VTK);
  mesh.mesh().update();
  const mesh::MeshView& view = mesh.mesh().view();
  Tree one(memory), two(memory);
  one.build(view, core::Threads(1), Builder::morton);
  check_tree(one, view);
  two.build(view, core::Threads(2), Builder::morton);
  EXPECT_TRUE(same_bytes(one, two));
  two.refit(view, core::Threads(2));
  check_tree(two, view);
  EXPECT_EQ(std::memcmp(one.nodes(), two.nodes(), sizeof(Node) * one.node_count()), 0);

  std::fill(ghosts.begin(), ghosts.end(), std::uint8_t(1)); // a piece without an owner
  one.build(view, core::Threads(1), Builder::morton);
  check_tree(one, view);
}

// The bytes that are promised, held and at the peak of a build, and node visits beside a tree by
// surface area, with room for how a small mesh happens to lie on the grid of codes: planes through
// the middle of a layer of hexahedra part tetrahedra that share one box.
TEST(Morton, BytesAndVisits) {
  for (const auto kind : {test::MeshKind::hexahedra, test::MeshKind::tetrahedra}) {
    const bool hexahedra = kind == test::MeshKind::hexahedra;
    const fixtures::SolverArrays arrays(box(kind, hexahedra ? 30 : 17));
    core::Memory memory;
    commit::CommittedMesh mesh("m", memory);
    give(mesh, 0, arrays);
    const mesh::MeshView& view = mesh.mesh().view();
    const std::int64_t before = memory.current();
    memory.reset_peak();
    Tree morton(memory), graded(memory);
    morton.build(view, core::Threads(1), Builder::morton);
    const double cells = double(arrays.cell_count());
    EXPECT_LE(double(morton.bytes()) / cells, 40.0);
    EXPECT_LE(double(memory.peak() - before) / cells, 80.0);
    graded.build(view, core::Threads(1), Builder::surface_area);
    std::vector<Vec3d> points;
    const Vec3d lo = morton.bounds_min(), hi = morton.bounds_max();
    for (std::size_t i = 0; i < 20000; ++i)
      points.push_back({lo.x + (hi.x - lo.x) * unit(i, 7), lo.y + (hi.y - lo.y) * unit(i, 8),
                        lo.z + (hi.z - lo.z) * unit(i, 9)});
    EXPECT_LE(visits(morton, points) / visits(graded, points), hexahedra ? 1.10 : 1.50);
  }
}

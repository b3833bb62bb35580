// Samples along bundles of rays: the same answers, bit for bit, as a batch of points.
#include "fixtures/simd_targets.h"
#include "query_test.h"
#include "ray_bundle_views.h"
#include "registered_amr.h"

namespace insitu::test {
namespace {

/// All tetrahedra turned the right way.
TestMesh sound_box(MeshKind kind, int size, double jitter, double offset = 0) {
  TestMesh mesh = box(kind, size, jitter, offset);
  for (MeshCell& cell : mesh.cells) {
    const Vertices x = mesh.cell_vertices(cell);
    if (cell.shape == Shape::tetrahedron && dot(cross(x[1] - x[0], x[2] - x[0]), x[3] - x[0]) < 0)
      std::swap(cell.vertices[1], cell.vertices[2]);
  }
  return mesh;
}

TEST(RayBundle, AnswersAsABatchDoes) {
  for (const auto kind : all_kinds)
    for (const double jitter : {0.0, 0.15}) {
      const fixtures::Committed m(sound_box(kind, 7, jitter));
      EXPECT_TRUE(m.sampler().mesh().free_of_folds) << kind_name(kind);
      const Counts c = check_views(m.sampler(), 1.0, 80, 1.5, 31, kind_name(kind));
      EXPECT_GT(c.found, 15000) << kind_name(kind);
      // Many samples along an axis lie on faces, and some views have few of them in a cell.
      EXPECT_LT(double(c.left), 0.5 * double(c.samples)) << kind_name(kind) << " " << jitter;
    }
}

TEST(RayBundle, OnEverySimdTarget) {
  for (const std::int64_t target : fixtures::simd_targets()) {
    fixtures::use_simd_target(target);
    for (const auto kind : {MeshKind::hexahedra, MeshKind::mixed, MeshKind::tetrahedra}) {
      const fixtures::Committed m(sound_box(kind, 6, 0.15));
      const Counts c = check_views(m.sampler(), 1.0, 12, 1.5, 46,
                                   std::string(kind_name(kind)) + ", " + hwy::TargetName(target));
      EXPECT_LT(double(c.left), 0.5 * double(c.samples)) << kind_name(kind);
    }
  }
  fixtures::use_simd_target(0);
}

TEST(RayBundle, FarAwayAndFarFromTheOrigin) {
  for (const auto kind : all_kinds) {
    const fixtures::Committed near(box(kind, 6));
    check_views(near.sampler(), 1.0, 20, 2e6, 32, std::string(kind_name(kind)) + ", far camera");
    const fixtures::Committed off(box(kind, 6, 0.2, 6.4e6));
    check_views(off.sampler(), 1.0, 20, 1.0, 33, std::string(kind_name(kind)) + ", offset");
    const fixtures::Committed thin(box(kind, 6, 0.2, 0, {1, 1, 1e-5}));
    check_views(thin.sampler(), 1e-2, 20, 0.01, 34, std::string(kind_name(kind)) + ", thin cells");
    check_views(thin.sampler(), 1.0, 20, 1.0, 35, std::string(kind_name(kind)) + ", thin cells");
  }
}

// No certificate proves anything there.
TEST(RayBundle, FoldsCollapsedCellsAndExactAnswers) {
  for (const auto kind : {MeshKind::hexahedra, MeshKind::wedges, MeshKind::mixed}) {
    const fixtures::Committed folded(make_mesh({.kind = kind, .size = 6, .jitter = 0.7}, 36));
    EXPECT_FALSE(folded.sampler().mesh().free_of_folds) << kind_name(kind);
    check_views(folded.sampler(), 1.0, 10, 1.0, 37, std::string(kind_name(kind)) + ", folded");
    const fixtures::Committed collapsed(
        make_mesh({.kind = kind, .size = 6, .jitter = 0.1, .collapse = 0.1}, 38));
    check_views(collapsed.sampler(), 1.0, 10, 1.0, 39,
                std::string(kind_name(kind)) + ", collapsed");
    const fixtures::Committed m(box(kind, 6));
    check_views(m.sampler(), 1.0, 10, 1.0, 40, std::string(kind_name(kind)) + ", exact",
                {INSITU_EXACT, 1.0});
  }
}

// A few odd cells take the proofs from the samples about them alone.
TEST(RayBundle, AFewOddCells) {
  for (const auto kind : {MeshKind::hexahedra, MeshKind::wedges, MeshKind::tetrahedra}) {
    TestMesh mesh = sound_box(kind, 7, 0.1);
    mesh.vertices[3 + 8 * (3 + 8 * 3)] += Vec3d{1.4, 0.3, -0.2};
    const fixtures::Committed m(mesh);
    EXPECT_FALSE(m.sampler().mesh().free_of_folds) << kind_name(kind);
    EXPECT_FALSE(m.sampler().tree().odd().empty()) << kind_name(kind);
    const Counts c =
        check_views(m.sampler(), 1.0, 60, 1.0, 45, std::string(kind_name(kind)) + ", odd");
    EXPECT_LT(double(c.left), 0.6 * double(c.samples)) << kind_name(kind);
  }
}

TEST(RayBundle, BlocksAndFloat32) {
  // A uniform block in float coordinates' place, and a curvilinear one of float32.
  for (const bool uniform : {true, false}) {
    fixtures::Committed m;
    insitu_block block = insitu_block_default();
    block.kind = uniform ? INSITU_BLOCK_UNIFORM : INSITU_BLOCK_CURVILINEAR;
    constexpr int n = 9;
    std::vector<float> points;
    Random random(41);
    for (int v = 0; v < n * n * n; ++v)
      for (const int i : {v % n, v / n % n, v / (n * n)})
        points.push_back(float(0.3 * (i + random.uniform(-0.2, 0.2))));
    for (int a = 0; a < 3; ++a) {
      block.vertices[a] = n;
      block.spacing[a] = 0.3;
    }
    const insitu_array array = insitu_array_of(points.data(), INSITU_FLOAT32, n * n * n, 3);
    if (!uniform)
      m.mesh.mesh().set_points(0, &array, 1);
    m.mesh.mesh().set_block(0, &block);
    m.commit();
    const Counts c =
        check_views(m.sampler(), 0.3, 60, 1.0, 42, uniform ? "uniform" : "curvilinear");
    EXPECT_LT(double(c.left), 0.3 * double(c.samples));
  }
}

/// Two pieces, the second inside the first in part: the first comes first wherever it is.
TEST(RayBundle, PiecesAndGhosts) {
  for (const double shift : {6.0, 3.3}) { // beside, within
    const TestMesh a = box(MeshKind::hexahedra, 6), b = box(MeshKind::mixed, 6, 0.2, shift);
    const fixtures::SolverArrays first(a), second(b);
    fixtures::Committed m;
    int piece = 0;
    for (const fixtures::SolverArrays* arrays : {&second, &first}) {
      const insitu_array p = arrays->point_array();
      const insitu_cells c = arrays->cells();
      m.mesh.mesh().set_points(piece, &p, 1);
      m.mesh.mesh().set_cells(piece++, &c);
    }
    std::vector<std::uint8_t> ghosts(std::size_t(second.cell_count()), 0);
    for (std::size_t i = 0; i < ghosts.size(); i += 5)
      ghosts[i] = 1;
    const insitu_array bits = insitu_array_of(ghosts.data(), INSITU_UINT8, second.cell_count(), 1);
    m.mesh.mesh().set_ghosts(0, &bits, INSITU_GHOSTS_VTK);
    m.commit();
    const Counts c = check_views(m.sampler(), 1.0, 60, 1.0, 43, "pieces");
    EXPECT_GT(c.found, 5000);
  }
}

TEST(RayBundle, AdaptiveMeshes) {
  for (int kind = 0; kind < 4; ++kind)
    for (const auto reconstruction : {INSITU_DUAL, INSITU_NEAREST}) {
      const Recipe recipe{.seed = 3, .kind = kind, .roots = 2, .levels = 3};
      if (AmrMesh probe = make_mesh(recipe); leaves_of(probe).empty())
        continue;
      RegisteredAmr mesh(recipe, reconstruction, [](const Vec3d& p) { return p.x; });
      const query::Sampler sampler = mesh.committed.sampler();
      const Vec3d size = sampler.tree().bounds_max() - sampler.tree().bounds_min();
      check_views(sampler, std::cbrt(size.x * size.y * size.z) / 24, 30, 1.0, 44,
                  "kind " + std::to_string(kind));
    }
}

TEST(RayBundle, NothingAskedAndNoCells) {
  const fixtures::Committed m(box(MeshKind::hexahedra, 3));
  RayBundleLocator bundle(m.sampler(), {});
  const std::vector<LatticeRay> rays(5, LatticeRay{{-1, 1.5, 1.5}, {1, 0, 0}});
  bundle.set_rays(rays, 5, 0.1);
  std::vector<query::Location> found(5 * 32, query::Location{-7, {}});
  const std::vector<std::uint32_t> none(5, 0), all(5, ~0u);
  bundle.locate(0, 32, none, found);
  EXPECT_EQ(found[0].cell, -7);
  bundle.locate(1000, 32, all, found); // behind the mesh
  EXPECT_EQ(found[0].cell, -1);
  EXPECT_EQ(bundle.left(), 0);
  bundle.locate(0, 32, all, found);
  EXPECT_EQ(found[9].cell, -1);
  EXPECT_GE(found[10].cell, 0);
  std::vector<query::ValueSample> alone(found.size(), query::ValueSample{-7, 0});
  const Numbers numbers(m.sampler().mesh(), false);
  std::vector<query::Location> none_wanted(found.size(), query::Location{-7, {}});
  bundle.locate(0, 32, all, numbers, alone, std::span(none_wanted).first(0));
  EXPECT_EQ(none_wanted[10].cell, -7);
  for (std::size_t i = 0; i < found.size(); ++i)
    EXPECT_EQ(alone[i].cell, found[i].cell) << i;
}

} // namespace
} // namespace insitu::test

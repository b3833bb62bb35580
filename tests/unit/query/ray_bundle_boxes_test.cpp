// Samples in gridlets and structured blocks along bundles of rays: cells whose places tell them.
#include <cmath>

#include "fixtures/simd_targets.h"
#include "ray_bundle_views.h"
#include "registered_amr.h"

namespace insitu::test {
namespace {

/// What a block is like.
struct BlockCase {
  const char* name;
  insitu_block_kind kind = INSITU_BLOCK_UNIFORM;
  bool is_float32 = false; ///< coordinates along the axes
  bool has_ghosts = false;
  double offset = 0;      ///< of the origin
  double spacing = 0.3;   ///< or about that
  int descending = 0;     ///< of the first axes
  int pieces = 1;         ///< side by side
  double most_left = 0.3; ///< of the samples, that batches get
};
constexpr int side = 9; // vertices

/// Blocks side by side along x.
class Blocks {
public:
  explicit Blocks(const BlockCase& of) {
    mesh::Mesh& mesh = committed.mesh.mesh();
    Random random(71);
    for (int p = 0; p < of.pieces; ++p) {
      insitu_block block = insitu_block_default();
      block.kind = of.kind;
      for (int a = 0; a < 3; ++a) {
        const double sign = a < of.descending ? -1.0 : 1.0;
        const double start = of.offset + (a == 0 ? p * (side - 1) * of.spacing : 0.0);
        block.vertices[a] = side;
        block.origin[a] = start;
        block.spacing[a] = sign * of.spacing;
        std::vector<double>& at = axes.emplace_back();
        std::vector<float>& at_float = float_axes.emplace_back();
        for (int i = 0; i < side; ++i) { // thin cells between wide ones; faces of pieces meet
          const double uneven = i % (side - 1) == 0 ? 0.0 : 0.45 * (i % 2 ? 1.0 : -1.0);
          at.push_back(start + sign * (i + uneven) * of.spacing);
          at_float.push_back(float(at.back()));
        }
        block.coordinates[a] = of.is_float32
                                   ? insitu_array_of(at_float.data(), INSITU_FLOAT32, side, 1)
                                   : insitu_array_of(at.data(), INSITU_FLOAT64, side, 1);
      }
      mesh.set_block(p, &block);
      constexpr std::int64_t cells = (side - 1) * (side - 1) * (side - 1);
      std::vector<std::uint8_t>& bits = ghosts.emplace_back(std::size_t(cells), std::uint8_t(0));
      for (std::uint8_t& bit : bits)
        bit = random.below(6) == 0;
      const insitu_array array = insitu_array_of(bits.data(), INSITU_UINT8, cells, 1);
      if (of.has_ghosts)
        mesh.set_ghosts(p, &array, INSITU_GHOSTS_VTK);
    }
    committed.commit();
  }

  std::vector<std::vector<double>> axes;
  std::vector<std::vector<float>> float_axes;
  std::vector<std::vector<std::uint8_t>> ghosts;
  fixtures::Committed committed;
};

const BlockCase block_cases[] = {
    {.name = "uniform"},
    {.name = "uniform, ghosts", .has_ghosts = true},
    {.name = "uniform, far away", .offset = 1e4, .most_left = 0.4},
    {.name = "uniform, coordinates' rounding shows",
     .offset = 6.4e6,
     .spacing = 1e-3,
     .most_left = 1},
    {.name = "uniform, two axes descend", .descending = 2},
    {.name = "uniform, three pieces", .pieces = 3},
    {.name = "rectilinear", .kind = INSITU_BLOCK_RECTILINEAR},
    {.name = "rectilinear of floats", .kind = INSITU_BLOCK_RECTILINEAR, .is_float32 = true},
    {.name = "rectilinear, ghosts", .kind = INSITU_BLOCK_RECTILINEAR, .has_ghosts = true},
    {.name = "rectilinear, two axes descend", .kind = INSITU_BLOCK_RECTILINEAR, .descending = 2},
    {.name = "rectilinear, far away",
     .kind = INSITU_BLOCK_RECTILINEAR,
     .offset = 6.4e6,
     .most_left = 0.4},
    {.name = "rectilinear, three pieces", .kind = INSITU_BLOCK_RECTILINEAR, .pieces = 3},
};

class BlocksInBundles : public testing::TestWithParam<BlockCase> {};

TEST_P(BlocksInBundles, AnswerAsABatchOnEverySimdTarget) {
  const BlockCase& of = GetParam();
  const Blocks blocks(of);
  for (const std::int64_t target : fixtures::simd_targets()) {
    fixtures::use_simd_target(target);
    const Counts c = check_views(blocks.committed.sampler(), of.spacing, 40, 1.0, 72,
                                 std::string(of.name) + ", " + hwy::TargetName(target));
    fixtures::use_simd_target(0);
    EXPECT_GT(c.found, 2000) << of.name;
    EXPECT_LE(double(c.left), of.most_left * double(c.samples)) << of.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Kinds, BlocksInBundles, testing::ValuesIn(block_cases),
                         [](const auto& of) {
                           std::string name;
                           for (const char* c = of.param.name; *c; ++c)
                             name += std::isalnum(*c) ? *c : '_';
                           return name;
                         });

/// Rays that no batch is needed for: they pass faces, but have no sample there.
TEST(BlocksInBundles, NoSampleIsLeftWhereNoneIsOnAFace) {
  for (const auto kind : {INSITU_BLOCK_UNIFORM, INSITU_BLOCK_RECTILINEAR}) {
    const Blocks blocks({.name = "", .kind = kind});
    std::vector<LatticeRay> rays;
    for (int i = 0; i < 256; ++i)
      rays.push_back(
          {{0.0137 + 0.00913 * (i % 16), 0.0211 + 0.00877 * (i / 16), 1e-3}, {0.36, 0.48, 0.8}});
    RayBundleLocator bundle(blocks.committed.sampler(), {});
    bundle.set_rays(rays, 16, 0.0731);
    const std::vector<std::uint32_t> wanted(rays.size(), 0xffff);
    std::vector<query::Location> found(rays.size() * 16);
    bundle.locate(0, 16, wanted, found);
    EXPECT_EQ(bundle.left(), 0) << kind;
    for (const query::Location& at : found)
      EXPECT_TRUE(at) << kind;
  }
}

/// A part of a uniform block, as one process of several has it, gives the whole block's
/// coordinates.
TEST(BlocksInBundles, APartGivesTheCoordinatesOfTheWhole) {
  constexpr int cells = 24, first = 7, count = 8; // along x
  const auto located = [&](int from, int n, std::span<const LatticeRay> rays) {
    fixtures::Committed committed;
    insitu_block block = insitu_block_default();
    block.kind = INSITU_BLOCK_UNIFORM;
    for (int a = 0; a < 3; ++a) {
      block.vertices[a] = a == 0 ? n + 1 : cells + 1;
      block.origin[a] = 0.013;
      block.spacing[a] = 0.97 / cells;
    }
    block.first[0] = from;
    committed.mesh.mesh().set_block(0, &block);
    committed.commit();
    RayBundleLocator bundle(committed.sampler(), {});
    bundle.set_rays(rays, 16, 0.0731);
    std::vector<query::Location> found(rays.size() * 16);
    bundle.locate(0, 16, std::vector<std::uint32_t>(rays.size(), 0xffff), found);
    return found;
  };
  std::vector<LatticeRay> rays;
  for (int i = 0; i < 256; ++i)
    rays.push_back(
        {{0.01 + 0.0513 * (i % 16), 0.0211 + 0.0377 * (i / 16), -0.1}, {0.36, 0.48, 0.8}});
  const auto whole = located(0, cells, rays), part = located(first, count, rays);
  int compared = 0;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    const std::int64_t x = whole[i].cell % cells - first;
    if (!whole[i] || x < 0 || x >= count)
      continue;
    ++compared;
    EXPECT_EQ(part[i].cell, whole[i].cell / cells * count + x);
    for (int a = 0; a < 3; ++a)
      EXPECT_EQ(part[i].parametric[a], whole[i].parametric[a]);
  }
  EXPECT_GT(compared, 500);
}

TEST(GridletsInBundles, AnswerAsABatchOnEverySimdTarget) {
  for (const std::uint64_t seed : {3, 6})
    for (const int kind : {0, 1, 2}) {
      RegisteredAmr mesh({.seed = seed, .kind = kind, .roots = 2, .levels = 3}, INSITU_DUAL,
                         [](const Vec3d& p) { return p.x; });
      const query::Sampler sampler = mesh.committed.sampler();
      const Vec3d size = sampler.tree().bounds_max() - sampler.tree().bounds_min();
      for (const std::int64_t target : fixtures::simd_targets()) {
        fixtures::use_simd_target(target);
        const Counts c =
            check_views(sampler, std::cbrt(size.x * size.y * size.z) / 24, 20, 1.0, 73,
                        "kind " + std::to_string(kind) + ", " + hwy::TargetName(target));
        fixtures::use_simd_target(0);
        EXPECT_GT(c.found, 500) << kind;
      }
    }
}

} // namespace
} // namespace insitu::test

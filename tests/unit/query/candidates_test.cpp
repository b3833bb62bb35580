// The cells whose boxes hold a point, with depths: a batch's way through the tree beside the node's
// own definitions, on all SIMD targets.
#include <algorithm>
#include <limits>
#include <vector>

#include "fixtures/simd_targets.h"
#include "query/batch/candidates.h"
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using test::box;

namespace {

using Found = std::vector<std::uint64_t>; ///< ranks, sorted

/// Of one point, from the root down by Node::child_box and Node::depth.
Found by_definition(const accel::Tree& tree, const query::BoxRule& rule, const Vec3d& p) {
  Found found;
  float lower[3], upper[3];
  if (!rule.box(p, lower, upper))
    return found;
  std::vector<std::uint32_t> open{0};
  while (!open.empty()) {
    const accel::Node& node = tree.nodes()[open.back()];
    open.pop_back();
    for (int c = 0; c < 8; ++c) {
      const accel::Box b = node.child_box(c);
      bool meets = node.meta[c] != 0;
      for (int a = 0; a < 3; ++a)
        meets &= b.lower[a] <= upper[a] && lower[a] <= b.upper[a];
      if (meets && node.is_inner(c))
        open.push_back(node.child_node(c));
      else if (meets)
        found.push_back(
            query::Candidate{node.child_cells(c), 0, node.depth(c, lower, upper), 0}.rank());
    }
  }
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<Found> by_batch(const accel::Tree& tree, const query::BoxRule& rule,
                            std::span<const Vec3d> points) {
  query::QueryBoxes boxes;
  query::TraversalScratch scratch;
  query::set_boxes(rule, points, boxes);
  query::find_candidates(tree, boxes, scratch);
  std::vector<Found> found(points.size());
  for (std::size_t c = 0; c < scratch.found; ++c)
    found[scratch.candidates[c].query].push_back(scratch.candidates[c].rank());
  for (Found& of : found)
    std::sort(of.begin(), of.end());
  return found;
}

/// In cells, on their vertices, outside, far away and nowhere.
std::vector<Vec3d> points_about(const mesh::MeshView& view) {
  std::vector<Vec3d> points = test::inner_points(view, 300, 5);
  for (const Vec3d& p : test::hard_points(view, 300, 6))
    points.push_back(p);
  for (std::size_t i = 0; i < 60; ++i)
    points.push_back(points[i] + 3.0 * (points[i] - points[i + 100]));
  constexpr double infinity = std::numeric_limits<double>::infinity();
  points.push_back({std::numeric_limits<double>::quiet_NaN(), 0, 0});
  points.push_back({0, infinity, 0});
  points.push_back({0, 0, -1e300});
  return points;
}

} // namespace

TEST(Candidates, AreThoseOfTheNodesBoxesOnAllTargets) {
  const struct {
    const char* what;
    double offset;
    Vec3d scale;
  } meshes[] = {{"a box", 0, {1, 1, 1}},
                {"far away", 1e7, {1, 1, 1}},
                {"tiny", 0, {1e-30, 1e-30, 1e-30}},
                {"huge", 0, {1e30, 1e30, 1e30}},
                {"flat", 0, {1, 1, 0}},
                {"layers", 0, {1, 1, 1e-6}},
                {"denormal", 0, {1e-39, 1e-39, 1e-39}}};
  for (const auto& of : meshes)
    for (const test::MeshKind kind : {test::MeshKind::hexahedra, test::MeshKind::tetrahedra}) {
      const test::TestMesh mesh = box(kind, 9, 0.2, of.offset, of.scale);
      const fixtures::Committed m(mesh, 1);
      const accel::Tree& tree = m.sampler().tree();
      const std::vector<Vec3d> points = points_about(m.mesh.mesh().view());
      const query::BoxRule rule(tree.origin());
      std::size_t candidates = 0;
      for (const std::int64_t target : fixtures::simd_targets()) {
        fixtures::use_simd_target(target);
        for (const std::size_t n :
             {points.size(), std::size_t(1)}) { // nodes with many and with one
          const auto found = by_batch(tree, rule, std::span(points).first(n));
          for (std::size_t q = 0; q < n; ++q) {
            EXPECT_EQ(found[q], by_definition(tree, rule, points[q]))
                << of.what << ", " << test::kind_name(kind) << ", " << hwy::TargetName(target)
                << ", point " << q << ": " << test::text(points[q]);
            candidates += found[q].size();
          }
        }
      }
      fixtures::use_simd_target(0);
      EXPECT_GT(candidates, points.size()) << of.what;
    }
}

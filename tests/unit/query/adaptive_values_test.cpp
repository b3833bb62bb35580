#include <cmath>
#include <cstring>
#include <deque>
#include <gtest/gtest.h>
#include <limits>

#include "core/random.h"
#include "fixtures/simd_targets.h"
#include "unit/query/registered_amr.h"

/// Values of adaptive meshes at many points at once.
namespace insitu::test {
namespace {

using math::Vec3d;

/// Hands over another field of cells, of T, whose numbers are all different.
template <class T>
void add_field(RegisteredAmr& mesh, const char* name, int components,
               std::deque<std::vector<T>>& keep) {
  for (std::size_t p = 0; p < mesh.amr.pieces.size(); ++p) {
    const std::int64_t n = mesh.amr.pieces[p].cell_count();
    std::vector<T>& values = keep.emplace_back();
    for (std::int64_t i = 0; i < n * components; ++i)
      values.push_back(T(core::random_unit(9, p, std::uint64_t(i)) - 0.5));
    const insitu_array array = insitu_array_of(
        values.data(), sizeof(T) == 4 ? INSITU_FLOAT32 : INSITU_FLOAT64, n, components);
    mesh.committed.mesh.mesh().set_field(std::int32_t(p), name, INSITU_CELL, &array, 1);
  }
}

/// Rows along the axes by a little more than half a finest cell, and points outside and of NaN.
std::vector<Vec3d> rows_through(RegisteredAmr& mesh, std::uint64_t seed) {
  const query::Sampler sampler = mesh.committed.sampler();
  const mesh::AmrView& view = mesh.amr.view();
  const Vec3d low = sampler.tree().bounds_min(), high = sampler.tree().bounds_max();
  std::vector<Vec3d> points;
  for (int row = 0; row < 90; ++row) {
    const int axis = row % 3;
    const double step = 0.57 * view.lattice.width(axis, view.finest_depth());
    Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = low[a] +
             core::random_unit(seed, std::uint64_t(row), std::uint64_t(a)) * (high[a] - low[a]);
    p[axis] = low[axis] - step;
    for (int i = 0; i < 61; ++i, p[axis] += step)
      points.push_back(p);
    if (row % 11 == 0)
      points.back().x = std::numeric_limits<double>::quiet_NaN();
  }
  return points;
}

bool same_bits(double a, double b) {
  return std::memcmp(&a, &b, sizeof a) == 0 || (std::isnan(a) && std::isnan(b));
}

/// Patches large enough for whole gridlets, and for such with empty cells beside a finer patch.
AmrMesh patches() {
  AmrMesh mesh;
  mesh.depth_of = {0, 1, 2};
  mesh.add_patch(0, {-3, 5, 0}, {26, 17, 18});
  mesh.add_patch(1, {4, 18, 8}, {20, 16, 14});
  mesh.add_patch(2, {16, 44, 24}, {24, 16, 16});
  return mesh;
}

const AmrMesh meshes[] = {patches(), make_mesh({.seed = 1, .kind = 0, .roots = 6, .levels = 3}),
                          make_mesh({.seed = 3, .kind = 2, .roots = 6, .levels = 2}),
                          make_mesh({.seed = 1, .kind = 5, .roots = 1, .levels = 7})};

class AdaptiveValues : public testing::TestWithParam<int> {};

TEST_P(AdaptiveValues, OfRowsAreThoseOfEachPointOnEverySimdTarget) {
  RegisteredAmr mesh(meshes[GetParam()], INSITU_DUAL,
                     [](const Vec3d& p) { return p.x * p.y - p.z; });
  std::deque<std::vector<double>> doubles;
  std::deque<std::vector<float>> floats;
  add_field(mesh, "floats", 1, floats);
  add_field(mesh, "doubles", 1, doubles);
  add_field(mesh, "pairs", 2, doubles);
  add_field(mesh, "float triples", 3, floats);
  mesh.committed.commit();
  const query::Sampler sampler = mesh.committed.sampler();
  const std::vector<Vec3d> points = rows_through(mesh, std::uint64_t(GetParam()));
  for (const char* name : {"f", "floats", "doubles", "pairs", "float triples"}) {
    const mesh::FieldView field = mesh.committed.mesh.mesh().field(name);
    const auto components = std::size_t(field.components);
    std::vector<double> alone(points.size() * components, std::numeric_limits<double>::quiet_NaN());
    std::int64_t in_gridlets = 0, in_others = 0;
    std::vector<query::Location> each;
    for (const Vec3d& p : points)
      each.push_back(sampler.locate(p));
    for (std::size_t i = 0; i < points.size(); ++i)
      if (const query::Location& at = each[i]) {
        ++(at.cell < sampler.mesh().first_cell[1] ? in_gridlets : in_others);
        sampler.interpolate(field, at, &alone[i * components]);
      }
    EXPECT_GT(in_others, 100);
    EXPECT_GE(in_gridlets, GetParam() == 0 ? 1500 : 0);
    for (const std::int64_t target : fixtures::simd_targets()) {
      fixtures::use_simd_target(target);
      std::vector<double> rows(alone.size(), 7.0);
      double* const to = rows.data();
      std::vector<double> backwards = rows;
      sampler.visit(mesh.committed.threads, points, {}, [&](query::Answered answered) {
        sampler.interpolate(std::span(&field, 1), answered, 0, &to);
        for (std::size_t k = 0; k < answered.locations.size(); ++k) {
          EXPECT_EQ(answered.locations[k].cell, each[answered.first + k].cell);
          EXPECT_EQ(answered.locations[k].parametric, each[answered.first + k].parametric);
        }
        // As answers of points in spatial order come, which lie elsewhere among all.
        const auto n = std::uint32_t(answered.locations.size());
        std::vector<accel::morton::Coded> order(n);
        for (std::uint32_t k = 0; k < n; ++k)
          order[k].id = n - 1 - k;
        answered.order = order.data();
        double* const other = backwards.data();
        sampler.interpolate(std::span(&field, 1), answered, 0, &other);
        for (std::size_t k = 0; k < n; ++k)
          for (std::size_t c = 0; c < components; ++c)
            EXPECT_TRUE(same_bits(backwards[(answered.first + n - 1 - k) * components + c],
                                  rows[(answered.first + k) * components + c]))
                << name << ", number " << answered.first + k << ", target " << target;
      });
      fixtures::use_simd_target(0);
      for (std::size_t i = 0; i < rows.size(); ++i)
        ASSERT_TRUE(same_bits(rows[i], alone[i]))
            << name << ", number " << i << ", target " << target << ": " << rows[i] << " not "
            << alone[i] << " (" << in_gridlets << " points in gridlets)";
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Meshes, AdaptiveValues, testing::Range(0, 4));

} // namespace
} // namespace insitu::test

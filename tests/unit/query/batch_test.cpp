// Batches: sorted inside or not, counted, and each answer with its reason.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <numeric>
#include <random>

#include "query/batch/order.h"
#include "query/batch/query_boxes.h"
#include "query_test.h"

using namespace insitu;
using math::Vec3d;
using query::Reason;
using test::all_kinds;
using test::box;
using test::same_bits;

namespace {

// A mesh and a batch large enough to be sorted inside.
constexpr int large = 22, many = 20000;

std::vector<Vec3d> shuffled_points(const fixtures::Committed& m) {
  std::vector<Vec3d> points = test::inner_points(m.mesh.mesh().view(), many, 31);
  for (std::size_t i = 0; i < points.size(); i += 11)
    points[i].y -= 50; // outside
  points[1].x = std::numeric_limits<double>::quiet_NaN();
  points[2].z = std::numeric_limits<double>::infinity();
  points[3].z = -1e300;
  return points;
}

std::uint32_t interleaved(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  std::uint32_t code = 0;
  for (std::uint32_t bit = 0; bit < 10; ++bit)
    code |= ((x >> bit & 1) | (y >> bit & 1) << 1 | (z >> bit & 1) << 2) << 3 * bit;
  return code;
}

} // namespace

TEST(Order, IsMortonsAndStableForAnyThreadCount) {
  const test::TestMesh from = box(test::MeshKind::hexahedra, large);
  std::vector<std::uint32_t> first;
  for (const int threads : {1, 2, 4}) {
    const fixtures::Committed m(from, threads);
    const std::vector<Vec3d> points = shuffled_points(m);
    core::Memory memory;
    query::SpatialOrder order(memory);
    const accel::Tree& tree = m.sampler().tree();
    const auto sorted = order.sort(m.threads, points, tree);
    ASSERT_EQ(sorted.size(), points.size());
    std::vector<std::uint32_t> numbers;
    const Vec3d low = tree.bounds_min(), size = tree.bounds_max() - low;
    for (std::size_t i = 0; i < sorted.size(); ++i) {
      numbers.push_back(sorted[i].id);
      const Vec3d& p = points[sorted[i].id];
      std::uint32_t place[3];
      for (int a = 0; a < 3; ++a) {
        const double t = std::floor((p[a] - low[a]) * (128.0 / size[a]));
        place[a] = std::uint32_t(t > 0 ? std::fmin(t, 127.0) : 0.0);
      }
      ASSERT_EQ(sorted[i].code, interleaved(place[0], place[1], place[2])) << test::text(p);
      if (i > 0) {
        ASSERT_TRUE(sorted[i - 1].code < sorted[i].code ||
                    (sorted[i - 1].code == sorted[i].code && sorted[i - 1].id < sorted[i].id));
      }
    }
    if (first.empty())
      first = numbers;
    EXPECT_EQ(numbers, first) << threads << " threads";
    std::sort(numbers.begin(), numbers.end());
    for (std::uint32_t i = 0; i < numbers.size(); ++i)
      ASSERT_EQ(numbers[i], i);
    EXPECT_GT(memory.current(INSITU_MEMORY_QUERY), 0);
    order.release();
    EXPECT_EQ(memory.current(INSITU_MEMORY_QUERY), 0);
  }
}

TEST(Order, IsWantedForScatteredPointsOnly) {
  const fixtures::Committed m(box(test::MeshKind::hexahedra, large), 1);
  const accel::Tree& tree = m.sampler().tree();
  std::vector<Vec3d> points = test::inner_points(m.mesh.mesh().view(), many, 32);
  EXPECT_TRUE(query::is_incoherent(points, tree));
  EXPECT_FALSE(query::is_incoherent(std::span(points).first(100), tree)) << "a small batch";
  std::sort(points.begin(), points.end(), [](const Vec3d& a, const Vec3d& b) { return a.x < b.x; });
  EXPECT_TRUE(query::is_incoherent(points, tree)) << "slabs are scattered";
  std::vector<Vec3d> row;
  for (int i = 0; i < many; ++i)
    row.push_back({(i % 1000) * 1e-3, (i / 1000) * 0.05, 0.5});
  EXPECT_FALSE(query::is_incoherent(row, tree));
  std::fill(row.begin(), row.end(), Vec3d{std::numeric_limits<double>::quiet_NaN(), 0, 0});
  EXPECT_FALSE(query::is_incoherent(row, tree)) << "NaN";
  const fixtures::Committed small(box(test::MeshKind::hexahedra, 4), 1);
  EXPECT_FALSE(query::is_incoherent(points, small.sampler().tree())) << "a small tree";
}

TEST(Batch, SortedInsideAnswersAsOneByOne) {
  for (const auto kind : all_kinds) {
    const test::TestMesh from = box(kind, kind == test::MeshKind::hexahedra ? large : 16);
    std::vector<query::Location> first;
    std::vector<std::uint8_t> first_reasons;
    for (const int threads : {1, 2, 4}) {
      const fixtures::Committed m(from, threads);
      const std::vector<Vec3d> points = shuffled_points(m);
      std::vector<query::Location> found(points.size());
      std::vector<std::uint8_t> reasons(points.size());
      const auto before = m.mesh.locate_counts().totals();
      m.sampler().locate(m.threads, points, found, {}, reasons);
      const auto after = m.mesh.locate_counts().totals();
      for (int r = 0; r < query::reason_count; ++r)
        EXPECT_EQ(after[std::size_t(r)] - before[std::size_t(r)],
                  std::count(reasons.begin(), reasons.end(), std::uint8_t(r)))
            << kind_name(kind) << ", reason " << r;
      if (first.empty()) {
        first = found;
        first_reasons = reasons;
        for (std::size_t i = 0; i < points.size(); i += 3)
          ASSERT_TRUE(same_bits(m.sampler().locate(points[i]), found[i]))
              << kind_name(kind) << ", point " << i << " " << test::text(points[i]);
      }
      for (std::size_t i = 0; i < points.size(); ++i)
        ASSERT_TRUE(same_bits(found[i], first[i])) << kind_name(kind) << ", point " << i;
      EXPECT_EQ(reasons, first_reasons) << kind_name(kind) << ", " << threads << " threads";
    }
  }
}

TEST(Batch, VisitsEachPointOnce) {
  const fixtures::Committed m(box(test::MeshKind::hexahedra, large), 4);
  const std::vector<Vec3d> points = shuffled_points(m);
  std::vector<std::atomic<int>> visits(points.size());
  m.sampler().visit(m.threads, points, {}, [&](const query::Answered& answered) {
    ASSERT_EQ(answered.locations.size(), answered.reasons.size());
    for (std::size_t k = 0; k < answered.locations.size(); ++k)
      ++visits[answered.item(k)];
  });
  for (std::size_t i = 0; i < points.size(); ++i)
    ASSERT_EQ(visits[i], 1) << "point " << i;
  m.sampler().visit(m.threads, {}, {}, [](const query::Answered&) { FAIL() << "no points"; });
}

TEST(Reasons, SayWhereThePointLies) {
  // Two unit cubes side by side; sums of vertices are exact.
  for (const auto kind : {test::MeshKind::hexahedra, test::MeshKind::voxels}) {
    const fixtures::Committed m(box(kind, 2, 0.0), 1);
    mesh::CellVertices cell;
    mesh::gather(m.mesh.mesh().view(), 0, cell);
    const auto middle = [&](std::initializer_list<int> corners) {
      Vec3d sum;
      for (const int v : corners)
        sum += cell.x[v];
      return sum / double(corners.size());
    };
    const bool voxel = kind == test::MeshKind::voxels;
    const struct {
      Vec3d p;
      Reason reason;
    } cases[] = {
        {middle({0, 1, 2, 3, 4, 5, 6, 7}), Reason::certified},
        {middle({0, 1, 2, 3}), Reason::on_face},
        {middle({0, 1}), Reason::on_edge},
        {cell.x[voxel ? 7 : 6], Reason::on_vertex},
        {cell.x[0] - Vec3d{1, 0, 0}, Reason::outside},
        {{std::numeric_limits<double>::quiet_NaN(), 0, 0}, Reason::outside},
    };
    for (const auto& c : cases) {
      Reason one = Reason::exact;
      (void)m.sampler().locate(c.p, -1, {}, &one);
      EXPECT_EQ(one, c.reason) << kind_name(kind) << " " << test::text(c.p);
      query::Location at;
      std::uint8_t reason = 99;
      m.sampler().locate(m.threads, std::span(&c.p, 1), std::span(&at, 1), {},
                         std::span(&reason, 1));
      EXPECT_EQ(reason, std::uint8_t(c.reason)) << kind_name(kind) << " " << test::text(c.p);
    }
  }
}

// One ulp inside a face no floating-point filter can tell; exact arithmetic says so.
TEST(Reasons, ExactArithmeticIsNamed) {
  const fixtures::Committed m(box(test::MeshKind::tetrahedra, 3, 0.2), 1);
  const mesh::MeshView& view = m.mesh.mesh().view();
  int exact = 0;
  for (std::int64_t c = 0; c < view.cell_count(); ++c) {
    mesh::CellVertices cell;
    mesh::gather(view, c, cell);
    const Vec3d p = (cell.x[0] + cell.x[1] + cell.x[2]) / 3.0; // on the face but for rounding
    Reason reason;
    const query::Location at = m.sampler().locate(p, -1, {}, &reason);
    if (!at)
      continue;
    mesh::gather(view, at.cell, cell);
    const cells::ExactResult truth = cells::contain_exact(cell.shape, cell.x, p);
    EXPECT_EQ(reason == Reason::exact,
              truth.where == cells::Containment::inside && truth.exact_used);
    exact += reason == Reason::exact;
  }
  EXPECT_GT(exact, 10);
}

TEST(Batch, BoxesAreTheRulesToTheLastBit) {
  const double none = std::numeric_limits<double>::quiet_NaN(),
               infinite = std::numeric_limits<double>::infinity();
  const Vec3d special[] = {{0, 0, 0},         {-0.0, 1, 2},       {none, 0, 0},    {0, infinite, 0},
                           {0, 0, -infinite}, {1e300, 0, 0},      {0, -2.9e37, 0}, {0, 0, 3.1e37},
                           {1e-300, 1, 1},    {5e-324, -1e-45, 1}};
  std::vector<Vec3d> points(std::begin(special), std::end(special));
  std::mt19937_64 engine(33);
  const auto uniform = [&](double low, double high) {
    return low + (high - low) * (double(engine() >> 11) * 0x1p-53);
  };
  while (points.size() < std::size_t(query::batch_size)) {
    const double size = std::pow(10.0, uniform(-12, 12));
    points.push_back({uniform(-size, size), uniform(-1, 1), uniform(0, size)});
  }
  for (const auto& rule : {query::BoxRule({0, 0, 0}), query::BoxRule({1e7, -0.3, 2}),
                           query::BoxRule({1e7, -0.3, 2}, 0.25, 0.01)})
    for (const std::size_t n : {std::size_t(1), points.size() - 1, points.size()}) {
      query::QueryBoxes boxes;
      query::set_boxes(rule, std::span(points).first(n), boxes);
      ASSERT_EQ(boxes.count, int(n));
      for (std::size_t q = 0; q < n; ++q) {
        float lower[3], upper[3];
        const bool has_box = rule.box(points[q], lower, upper);
        bool meets_something = true;
        for (int a = 0; a < 3; ++a) {
          const float high = boxes.bounds[q][2 * a], low = -boxes.bounds[q][2 * a + 1];
          if (has_box) {
            EXPECT_EQ(std::memcmp(&low, &lower[a], sizeof low), 0) << test::text(points[q]);
            EXPECT_EQ(std::memcmp(&high, &upper[a], sizeof high), 0) << test::text(points[q]);
            EXPECT_LE(double(low), points[q][a] - rule.origin[a]);
            EXPECT_GE(double(high), points[q][a] - rule.origin[a]);
          }
          meets_something &= low <= high;
        }
        EXPECT_EQ(meets_something, has_box) << test::text(points[q]);
      }
    }
}

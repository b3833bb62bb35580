/// Queries that no solver should ask: a status or a defined answer, never a crash.
#include <algorithm>
#include <cfloat>
#include <cmath>
#include <limits>
#include <type_traits>

#include "bad_input.h"

using namespace bad_input;

namespace {

const double not_a_number = std::numeric_limits<double>::quiet_NaN();
const double infinite = std::numeric_limits<double>::infinity();

} // namespace

// Counts and ids are 64 bits wide wherever a caller can see them; a flat id fits the tree's 32 bits
// since a mesh of more cells is refused (AMeshOfTooManyCells).
static_assert(std::is_same_v<decltype(insitu_array::count), std::int64_t>);
static_assert(std::is_same_v<decltype(insitu_cells::count), std::int64_t>);
static_assert(std::is_same_v<decltype(insitu_locate_args::cells), std::int64_t*>);
static_assert(std::is_same_v<decltype(insitu_report::points_located), std::int64_t>);

TEST(BadQueries, PointsThatAreNoPlaceAreOutside) {
  Box box;
  std::vector<double> xyz;
  const double odd[] = {not_a_number, -not_a_number, infinite, -infinite, 1e300, -1e300,
                        DBL_MAX,      -DBL_MAX,      3e38,     -3e38,     1e40,  DBL_MIN / 16,
                        -0.0,         5e-324,        FLT_MAX,  1e37};
  std::vector<bool> is_inside;
  for (const double value : odd)
    for (int axis = 0; axis < 3; ++axis) {
      double p[3] = {0.5, 0.5, 0.5};
      p[axis] = value;
      xyz.insert(xyz.end(), p, p + 3);
      // At y = z = 0.5 the sheared mesh begins beyond x = 0, and at z = 0.5 beyond y = 0.
      is_inside.push_back(std::fabs(value) < 1e-30 && axis == 2);
      xyz.insert(xyz.end(), {1.5, 0.5, 0.5}); // its neighbours are answered as ever
      is_inside.push_back(true);
    }
  const auto n = std::int64_t(xyz.size() / 3);
  const insitu_array points = insitu_array_of(xyz.data(), INSITU_FLOAT64, n, 3);
  for (const insitu_accuracy accuracy : {INSITU_STANDARD, INSITU_EXACT}) {
    std::vector<std::int64_t> cells(std::size_t(n), 77);
    std::vector<std::int32_t> pieces(std::size_t(n), 77);
    std::vector<double> parametric(std::size_t(3 * n), 77), values(std::size_t(n), 77);
    std::vector<std::uint8_t> found(std::size_t(n), 77), reasons(std::size_t(n), 77);
    insitu_sample_args args = insitu_sample_args_default();
    args.locate.points = &points;
    args.locate.accuracy = accuracy;
    args.locate.cells = cells.data();
    args.locate.pieces = pieces.data();
    args.locate.parametric = parametric.data();
    args.locate.found = found.data();
    args.locate.reasons = reasons.data();
    const char* const name = "pressure";
    double* const to = values.data();
    args.fields = &name;
    args.field_count = 1;
    args.values = &to;
    ASSERT_EQ(insitu_mesh_sample(box.mesh, &args), INSITU_OK) << message();
    for (std::size_t i = 0; i < std::size_t(n); ++i) {
      EXPECT_EQ(found[i], is_inside[i]) << i;
      EXPECT_EQ(cells[i] >= 0, is_inside[i]) << i;
      EXPECT_EQ(pieces[i], is_inside[i] ? 0 : -1) << i;
      EXPECT_EQ(std::isnan(parametric[3 * i + 2]), !is_inside[i]) << i;
      EXPECT_EQ(std::isnan(values[i]), !is_inside[i]) << i;
      EXPECT_EQ(reasons[i] == INSITU_REASON_OUTSIDE, !is_inside[i]) << i;
      if (i % 2 == 1) {
        EXPECT_EQ(cells[i], 1) << i;
      }
    }
    double value = 0;
    std::int32_t inside = 77;
    for (const double v : odd) {
      const double p[3] = {v, 0.5, 0.5};
      EXPECT_EQ(insitu_mesh_sample_point(box.mesh, name, p, &value, &inside), INSITU_OK);
      EXPECT_EQ(inside, 0) << v;
      EXPECT_TRUE(std::isnan(value));
    }
  }
}

TEST(BadQueries, NearestCellsAndVertices) {
  Box box;
  std::vector<double> xyz{0.5,      0.5, 0.5, 9,     0.5, 0.5, not_a_number, 0, 0,
                          infinite, 0,   0,   1e300, 0,   0};
  const insitu_array points = insitu_array_of(xyz.data(), INSITU_FLOAT64, 5, 3);
  insitu_locate_args args = insitu_locate_args_default();
  args.points = &points;
  std::int64_t cells[5];
  double distances[5], nearest[15];
  std::uint8_t found[5];
  args.cells = cells;
  args.found = found;
  args.distances = distances;
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT,
                 "distances: asked for without INSITU_OUTSIDE_NEAREST");
  args.outside = insitu_outside(2);
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT,
                 "outside: unknown value 2");
  args.outside = INSITU_OUTSIDE_NEAREST;
  for (const double bad : {-1.0, not_a_number}) {
    args.greatest_distance = bad;
    EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT, "greatest_distance");
  }
  args.greatest_distance = 0;
  args.nearest = distances;
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT, "nearest overlaps");
  args.nearest = nearest;
  ASSERT_EQ(insitu_mesh_locate(box.mesh, &args), INSITU_OK) << message();
  EXPECT_TRUE(cells[0] >= 0 && cells[1] >= 0 && cells[2] < 0 && cells[3] < 0);
  EXPECT_TRUE(found[0] == 1 && found[1] == 0);
  EXPECT_EQ(distances[0], 0.0);
  EXPECT_GT(distances[1], 1.0);
  EXPECT_EQ(nearest[0], 0.5);
  EXPECT_TRUE(std::isnan(distances[2]) && std::isnan(nearest[6]) && std::isnan(distances[3]));
  EXPECT_TRUE(cells[4] < 0 || distances[4] > 1e299); // beyond any mesh, at any distance

  insitu_vertices_args near = insitu_vertices_args_default();
  near.points = &points;
  std::int64_t vertices[10];
  near.vertices = vertices;
  near.distances = distances; // room for one a point
  for (const std::int32_t bad : {0, -3}) {
    near.nearest = bad;
    EXPECT_REFUSED(insitu_mesh_nearest_vertices(box.mesh, &near), INSITU_ERROR_ARGUMENT,
                   "at least 1 expected");
  }
  near.nearest = 1;
  near.vertex_base = 2;
  EXPECT_REFUSED(insitu_mesh_nearest_vertices(box.mesh, &near), INSITU_ERROR_ARGUMENT,
                 "vertex_base: 2, 0 or 1 expected");
  near.vertex_base = 1;
  near.greatest_distance = 20;
  ASSERT_EQ(insitu_mesh_nearest_vertices(box.mesh, &near), INSITU_OK) << message();
  EXPECT_TRUE(vertices[0] > 0 && vertices[1] > 0 && vertices[2] == 0 && vertices[3] == 0);
  EXPECT_TRUE(std::isnan(distances[2]));
  near.size = 7;
  EXPECT_EQ(insitu_mesh_nearest_vertices(box.mesh, &near), INSITU_ERROR_ARGUMENT);
  EXPECT_EQ(insitu_mesh_nearest_vertices(box.mesh, nullptr), INSITU_ERROR_ARGUMENT);
}

TEST(BadQueries, EveryOutputMayBeNull) {
  Box box;
  const double xyz[] = {0.5, 0.5, 0.5, 9, 9, 9};
  const insitu_array points = insitu_array_of(xyz, INSITU_FLOAT64, 2, 3);
  insitu_locate_args args = insitu_locate_args_default();
  args.points = &points;
  EXPECT_EQ(insitu_mesh_locate(box.mesh, &args), INSITU_OK) << message();
  insitu_report report = insitu_report_default();
  EXPECT_EQ(insitu_session_report(box.session, &report), INSITU_OK);
  EXPECT_EQ(report.points_located, 2);
  EXPECT_EQ(report.points_outside, 1);
  insitu_sample_args sample = insitu_sample_args_default();
  sample.locate = args;
  EXPECT_EQ(insitu_mesh_sample(box.mesh, &sample), INSITU_OK) << message();
  const char* const name = "pressure";
  sample.fields = &name;
  sample.field_count = 1;
  EXPECT_REFUSED(insitu_mesh_sample(box.mesh, &sample), INSITU_ERROR_ARGUMENT, "values is null");
  double* nothing = nullptr;
  sample.values = &nothing;
  EXPECT_REFUSED(insitu_mesh_sample(box.mesh, &sample), INSITU_ERROR_ARGUMENT, "values[0] is null");
  const char* no_name = nullptr;
  sample.fields = &no_name;
  EXPECT_REFUSED(insitu_mesh_sample(box.mesh, &sample), INSITU_ERROR_ARGUMENT, "fields[0] is null");
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, nullptr), INSITU_ERROR_ARGUMENT, "args: null");
  EXPECT_REFUSED(insitu_mesh_sample(box.mesh, nullptr), INSITU_ERROR_ARGUMENT, "args: null");
}

TEST(BadQueries, CountsOfZeroAskNothing) {
  Box box;
  insitu_array points = insitu_array_of(nullptr, INSITU_FLOAT64, 0, 3);
  std::int64_t cell = 77;
  double value = 77;
  double* to = nullptr;
  const char* const name = "pressure";
  insitu_sample_args args = insitu_sample_args_default();
  args.locate.points = &points;
  args.locate.cells = &cell;
  args.fields = &name;
  args.field_count = 1;
  args.values = &to;
  EXPECT_EQ(insitu_mesh_sample(box.mesh, &args), INSITU_OK) << message();
  to = &value;
  points.extent[0] = 0;
  points.extent[1] = 5; // an empty section
  EXPECT_EQ(insitu_mesh_sample(box.mesh, &args), INSITU_OK) << message();
  EXPECT_EQ(insitu_mesh_locate(box.mesh, &args.locate), INSITU_OK) << message();
  EXPECT_EQ(cell, 77);
  EXPECT_EQ(value, 77);
  points = insitu_array_of(nullptr, INSITU_FLOAT64, 1, 3);
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args.locate), INSITU_ERROR_ARGUMENT, "points",
                 "data is null", "1 items");
  points = insitu_array_of(&value, INSITU_FLOAT64, -1, 3);
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args.locate), INSITU_ERROR_ARGUMENT, "count -1");
}

TEST(BadQueries, OverlapsAreRefusedAndNamed) {
  Box box;
  constexpr std::int64_t n = 8;
  // Points and all outputs in one piece of memory, in 8 byte words.
  std::vector<double> memory(512, 0.5);
  double* const xyz = memory.data();
  const insitu_array interleaved = insitu_array_of(xyz, INSITU_FLOAT64, n, 3);
  insitu_array separate[3];
  for (int a = 0; a < 3; ++a)
    separate[a] = insitu_array_of(xyz + 8 * a, INSITU_FLOAT64, n, 1);

  const auto good = [&] {
    insitu_locate_args args = insitu_locate_args_default();
    args.points = &interleaved;
    args.cells = reinterpret_cast<std::int64_t*>(xyz + 24); // right behind the points
    args.parametric = xyz + 32;
    args.pieces = reinterpret_cast<std::int32_t*>(xyz + 56);
    args.found = reinterpret_cast<std::uint8_t*>(xyz + 60);
    args.reasons = reinterpret_cast<std::uint8_t*>(xyz + 61);
    return args;
  };
  insitu_locate_args args = good();
  EXPECT_EQ(insitu_mesh_locate(box.mesh, &args), INSITU_OK) << message();

  args.cells = reinterpret_cast<std::int64_t*>(xyz + 23);
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT,
                 "cells overlaps the points");
  args.points = separate;
  args.point_arrays = 3;
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT,
                 "cells overlaps the points, array 2");
  args = good();
  args.parametric = xyz + 31;
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT,
                 "parametric overlaps cells");
  args = good();
  args.found = args.reasons;
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT,
                 "reasons overlaps found");
  args = good();
  args.pieces = reinterpret_cast<std::int32_t*>(xyz + 55) + 1;
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT,
                 "parametric overlaps pieces");

  // Points that run backwards, and blocks.
  insitu_array backwards = insitu_array_of(xyz + 21, INSITU_FLOAT64, n, 3);
  backwards.stride[0] = -24;
  args = good();
  args.points = &backwards;
  EXPECT_EQ(insitu_mesh_locate(box.mesh, &args), INSITU_OK) << message();
  args.cells = reinterpret_cast<std::int64_t*>(xyz);
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT,
                 "cells overlaps the points");
  insitu_array block = insitu_array_of(xyz, INSITU_FLOAT64, n, 3);
  block.extent[0] = 4;
  block.extent[1] = 2;
  block.stride[0] = 24;
  block.stride[1] = 200 * 8;
  args = good();
  args.points = &block;
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT, "the points");

  // What the mesh itself is made of: any of it would be changed without a commit.
  args = good();
  args.parametric = box.xyz.data() + 5;
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT,
                 "parametric overlaps the array 'piece 0 points' of mesh 'box'");
  args = good();
  args.pieces = box.connectivity.data();
  EXPECT_REFUSED(insitu_mesh_locate(box.mesh, &args), INSITU_ERROR_ARGUMENT, "pieces",
                 "piece 0 connectivity");

  // Sample: fields are read while values are written.
  const char* const names[2] = {"pressure", "velocity"};
  double* to[2] = {xyz + 100, xyz + 108};
  insitu_sample_args sample = insitu_sample_args_default();
  sample.locate = good();
  sample.fields = names;
  sample.field_count = 2;
  sample.values = to;
  EXPECT_EQ(insitu_mesh_sample(box.mesh, &sample), INSITU_OK) << message();
  to[1] = xyz + 107;
  EXPECT_REFUSED(insitu_mesh_sample(box.mesh, &sample), INSITU_ERROR_ARGUMENT,
                 "values[1] overlaps values[0]");
  to[1] = xyz;
  EXPECT_REFUSED(insitu_mesh_sample(box.mesh, &sample), INSITU_ERROR_ARGUMENT, "values[1]",
                 "the points");
  to[1] = box.pressure.data() + 3;
  EXPECT_REFUSED(insitu_mesh_sample(box.mesh, &sample), INSITU_ERROR_ARGUMENT, "values[1]",
                 "field 'pressure'");
  to[1] = xyz + 108;
  to[0] = box.density.data(); // not sampled: answers may become a field of the mesh
  EXPECT_EQ(insitu_mesh_sample(box.mesh, &sample), INSITU_OK) << message();
  to[0] = xyz + 100;
  to[1] = xyz + 63;
  sample.locate.parametric = xyz + 64;
  EXPECT_REFUSED(insitu_mesh_sample(box.mesh, &sample), INSITU_ERROR_ARGUMENT, "values[1]",
                 "parametric");
}

/// Answers may go into the gaps of an array that the solver keeps with room between its items.
TEST(BadQueries, RoomBetweenTheItemsOfAMeshArrayIsTheSolvers) {
  Box box;
  // Levels of 5 values: the field in 0 to 3, room for an answer in 4.
  std::vector<double> levels(6 * 5, -1.0);
  insitu_array field = insitu_array_of(levels.data(), INSITU_FLOAT64, 24, 1);
  field.extent[0] = 4;
  field.extent[1] = 6;
  field.stride[1] = 5 * 8;
  ASSERT_EQ(insitu_mesh_field(box.mesh, 0, "padded", INSITU_CELL, &field, 1), INSITU_OK);
  ASSERT_EQ(insitu_mesh_commit(box.mesh, nullptr), INSITU_OK) << message();
  const double xyz[] = {0.5, 0.5, 0.5};
  const insitu_array points = insitu_array_of(xyz, INSITU_FLOAT64, 1, 3);
  const char* const name = "pressure";
  double* const to = &levels[4];
  insitu_sample_args args = insitu_sample_args_default();
  args.locate.points = &points;
  args.fields = &name;
  args.field_count = 1;
  args.values = &to;
  EXPECT_EQ(insitu_mesh_sample(box.mesh, &args), INSITU_OK) << message();
  EXPECT_GT(levels[4], 0.0);
  EXPECT_EQ(levels[3], -1.0);
}

TEST(BadQueries, AnyNumberOfPointsNeedsLittleScratch) {
  Box box;
  // Three million points, all of them the same few: strides that cancel.
  std::vector<double> xyz(3 * 4096, 0.5);
  insitu_array points = insitu_array_of(xyz.data() + 3 * 2047, INSITU_FLOAT64, 0, 3);
  points.extent[0] = points.extent[1] = 1750;
  points.stride[0] = 24;
  points.stride[1] = -24;
  xyz[3 * 2047 + 3 * 1749] = 9.0; // the item (1749, 0) alone
  std::vector<std::uint8_t> found(1750 * 1750, 77);
  insitu_locate_args args = insitu_locate_args_default();
  args.points = &points;
  args.found = found.data();
  ASSERT_EQ(insitu_mesh_locate(box.mesh, &args), INSITU_OK) << message();
  EXPECT_EQ(std::count(found.begin(), found.end(), 1), 1750 * 1750 - 1);
  EXPECT_EQ(found[1749], 0);
  insitu_report report = insitu_report_default();
  ASSERT_EQ(insitu_session_report(box.session, &report), INSITU_OK);
  EXPECT_LT(report.bytes_by_purpose[INSITU_MEMORY_QUERY], 100 << 20);
}

/// Minutes long, hence not run by itself: --gtest_also_run_disabled_tests.
TEST(BadQueries, DISABLED_MoreThanTwoToThe31Points) {
  Box box;
  std::vector<double> xyz(3 * 100000, 9.0);
  insitu_array points = insitu_array_of(xyz.data() + 3 * 50000, INSITU_FLOAT64, 0, 3);
  points.extent[0] = points.extent[1] = 46350; // 46350^2 > 2^31
  points.stride[0] = 24;
  points.stride[1] = -24;
  for (int a = 0; a < 3; ++a)
    xyz[std::size_t(3 * (50000 - 46349) + a)] = 0.5; // the item (0, 46349) alone
  const std::int64_t n = std::int64_t(46350) * 46350;
  std::vector<std::uint8_t> found(std::size_t(n), 77);
  insitu_locate_args args = insitu_locate_args_default();
  args.points = &points;
  args.found = found.data();
  ASSERT_EQ(insitu_mesh_locate(box.mesh, &args), INSITU_OK) << message();
  EXPECT_EQ(std::count(found.begin(), found.end(), 0), n - 1);
  EXPECT_EQ(found[std::size_t(n) - 46350], 1);
}

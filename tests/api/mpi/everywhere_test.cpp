/// Queries of the cells of all processes: mpiexec -n 1, 3, 4. Slabs of one uniform grid along x,
/// the last process without any; points on seams, inside and outside.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <insitu/insitu.hpp>
#include <numeric>
#include <vector>

#include "api/mpi/main.h"

namespace {

constexpr std::int64_t nx = 12, ny = 3, nz = 2;
constexpr double origin[3] = {0.1, -0.3, 7.0}, spacing[3] = {0.1, 0.3, 0.7};

/// The slab of a process, from column `begin` to `end`; the last of several has none.
struct Slab {
  explicit Slab(int r) {
    const int parts = std::max(1, size() - 1);
    begin = r < parts ? nx * r / parts : nx;
    end = r < parts ? nx * (r + 1) / parts : nx;
  }
  bool empty() const { return begin == end; }
  std::int64_t begin, end;
};

double coordinate(int axis, std::int64_t i) {
  return origin[axis] + double(i) * spacing[axis];
}
double field_at(double x, double y, double z) {
  return 2 * x - y + 0.5 * z;
}

struct Solver {
  Solver() {
    static const MPI_Comm world = MPI_COMM_WORLD;
    insitu::Options o;
    o.output = "everywhere";
    o.communicator = &world;
    session = std::make_unique<insitu::Session>(o);
    mesh = session->mesh("grid");
    const Slab slab(rank());
    if (slab.empty()) {
      mesh->commit();
      return;
    }
    mesh->uniform_block({slab.end - slab.begin + 1, ny + 1, nz + 1},
                        {origin[0], origin[1], origin[2]}, {spacing[0], spacing[1], spacing[2]},
                        {slab.begin, 0, 0});
    for (std::int64_t k = 0; k < nz; ++k)
      for (std::int64_t j = 0; j < ny; ++j)
        for (std::int64_t i = slab.begin; i < slab.end; ++i)
          ids.push_back(i + nx * (j + ny * k));
    for (std::int64_t k = 0; k <= nz; ++k)
      for (std::int64_t j = 0; j <= ny; ++j)
        for (std::int64_t i = slab.begin; i <= slab.end; ++i)
          values.push_back(field_at(coordinate(0, i), coordinate(1, j), coordinate(2, k)));
    mesh->global_ids(insitu::Association::cell, ids);
    mesh->vertex_field("f", values);
    mesh->commit();
  }
  std::unique_ptr<insitu::Session> session;
  std::optional<insitu::Mesh> mesh;
  std::vector<std::int64_t> ids;
  std::vector<double> values;
};

/// Vertices of columns, which lie on seams too, and the middles of cells; the last is outside.
std::vector<double> points() {
  std::vector<double> all;
  for (std::int64_t i = 0; i <= nx; ++i) {
    all.insert(all.end(), {coordinate(0, i), coordinate(1, 1), coordinate(2, 1)});
    all.insert(all.end(), {coordinate(0, i), coordinate(1, 0) + 0.1, coordinate(2, 0) + 0.2});
  }
  for (std::int64_t i = 0; i < nx; ++i)
    all.insert(all.end(),
               {coordinate(0, i) + 0.05, coordinate(1, 2) + 0.1, coordinate(2, 1) + 0.1});
  all.insert(all.end(), {99, 99, 99});
  return all;
}
/// The lowest id of the cells there.
std::int64_t owner(std::size_t point) {
  const auto n = std::size_t(nx);
  if (point < 2 * (n + 1))
    return std::max<std::int64_t>(std::int64_t(point / 2) - 1, 0);
  return point < 3 * n + 2 ? std::int64_t(point) - 2 * (nx + 1) + nx * (2 + ny) : -1;
}
int process_of(std::int64_t column) {
  for (int r = 0; r < size(); ++r)
    if (Slab slab(r); column >= slab.begin && column < slab.end)
      return r;
  return -1;
}

TEST(Everywhere, SeamsHaveOneOwner) {
  const Solver solver;
  const std::vector<double> all = points();
  insitu::LocateOptions options;
  options.everywhere = true;
  options.reasons = true;
  // All but the first ask; a process without the field asks where, and not for values.
  const std::vector<double> asked = rank() == 0 && size() > 1 ? std::vector<double>() : all;
  const insitu::Locations at = solver.mesh->locate(insitu::Points(asked), options);
  ASSERT_EQ(at.size(), asked.size() / 3);
  for (std::size_t i = 0; i < at.size(); ++i) {
    const std::int64_t id = owner(i);
    EXPECT_EQ(at.found[i], id >= 0) << "point " << i;
    EXPECT_EQ(at.global_cells[i], id) << "point " << i;
    EXPECT_EQ(at.ranks[i], id < 0 ? -1 : process_of(id % nx)) << "point " << i;
    EXPECT_EQ(at.pieces[i], id < 0 ? -1 : 0) << "point " << i;
  }
  const std::vector<double> sampled = Slab(rank()).empty() ? std::vector<double>() : all;
  const insitu::Samples f = solver.mesh->sample("f", insitu::Points(sampled), options);
  for (std::size_t i = 0; i < f.size(); ++i)
    if (owner(i) < 0)
      EXPECT_TRUE(std::isnan(f(i)));
    else // a linear field; sums of eight terms below 8
      EXPECT_NEAR(f(i), field_at(all[3 * i], all[3 * i + 1], all[3 * i + 2]), 1e-14) << i;
}

/// Points outside, asked by the first process alone: the nearest cell of any process, its distance
/// and its nearest point, which are known in closed form, and the value there. A point beyond
/// greatest_distance has no answer, one inside has distance 0.
TEST(Everywhere, NearestCells) {
  const Solver solver;
  const double low[3] = {coordinate(0, 0), coordinate(1, 0), coordinate(2, 0)},
               high[3] = {coordinate(0, nx), coordinate(1, ny), coordinate(2, nz)};
  std::vector<double> asked;
  const bool asks = rank() == 0;
  for (std::int64_t i = 0; asks && i < nx; ++i) { // beside middles of sides, beyond an edge, inside
    const double x = coordinate(0, i) + 0.05;
    asked.insert(asked.end(), {x, low[1] - 0.25, low[2] + 0.35});
    asked.insert(asked.end(), {x, high[1] + 0.3, high[2] + 0.4});
    asked.insert(asked.end(), {x, low[1] + 0.1, low[2] + 0.2});
    asked.insert(asked.end(), {x, low[1] + 0.1, high[2] + 2.0});
  }
  insitu::LocateOptions options;
  options.everywhere = options.nearest = true;
  options.greatest_distance = 1.0;
  const insitu::Locations at = solver.mesh->locate(insitu::Points(asked), options);
  const insitu::Samples f = solver.mesh->sample("f", insitu::Points(asked), options);
  ASSERT_EQ(at.distances.size(), asked.size() / 3);
  for (std::size_t i = 0; i < at.size(); ++i) {
    const auto column = std::int64_t(i / 4);
    const bool is_far = i % 4 == 3;
    double place[3], squared = 0.0;
    for (std::size_t a = 0; a < 3; ++a) {
      place[a] = std::clamp(asked[3 * i + a], low[a], high[a]);
      squared += (asked[3 * i + a] - place[a]) * (asked[3 * i + a] - place[a]);
    }
    const std::int64_t j = i % 4 == 1 ? ny - 1 : 0, k = i % 4 == 1 ? nz - 1 : 0;
    EXPECT_EQ(at.found[i], i % 4 == 2) << i;
    EXPECT_EQ(at.global_cells[i], is_far ? -1 : column + nx * (j + ny * k)) << i;
    EXPECT_EQ(at.ranks[i], is_far ? -1 : process_of(column)) << i;
    EXPECT_EQ(std::isnan(at.distances[i]), is_far) << i;
    EXPECT_EQ(std::isnan(f(i)), is_far) << i;
    if (is_far)
      continue;
    EXPECT_NEAR(at.distances[i], std::sqrt(squared), 1e-14) << i; // of coordinates up to 9
    for (std::size_t a = 0; a < 3; ++a)
      EXPECT_NEAR(at.nearest[3 * i + a], place[a], 1e-14) << i;
    EXPECT_NEAR(f(i), field_at(place[0], place[1], place[2]), 1e-13) << i;
  }
}

TEST(Everywhere, LocalQueriesStayLocal) {
  const Solver solver;
  const std::vector<double> all = points();
  const insitu::Locations at = solver.mesh->locate(insitu::Points(all));
  const Slab slab(rank());
  for (std::size_t i = 0; i < at.size(); ++i) {
    const double column = (all[3 * i] - origin[0]) / spacing[0];
    const bool near = column > double(slab.begin) - 0.25 && column < double(slab.end) + 0.25;
    EXPECT_EQ(at.found[i], !slab.empty() && near) << "point " << i;
  }
}

/// What one process gets wrong fails on all of them, which then go on.
TEST(Everywhere, AnErrorOfOneIsAnErrorOfAll) {
  const Solver solver;
  const double one[3] = {0.15, 0.0, 7.1};
  const insitu_array array = insitu_array_of(one, INSITU_FLOAT64, 1, 3);
  const bool is_last = rank() == size() - 1;
  insitu_locate_args args = insitu_locate_args_default();
  args.points = is_last ? nullptr : &array;
  args.scope = INSITU_SCOPE_EVERYWHERE;
  EXPECT_EQ(insitu_mesh_locate(solver.mesh->handle(), &args), INSITU_ERROR_ARGUMENT);
  EXPECT_NE(std::string(insitu_last_message()).find("points: the array is null"), std::string::npos)
      << insitu_last_message();
  args.points = &array;
  args.accuracy = is_last ? INSITU_EXACT : INSITU_STANDARD;
  EXPECT_EQ(insitu_mesh_locate(solver.mesh->handle(), &args),
            size() > 1 ? INSITU_ERROR_ARGUMENT : INSITU_OK);
  args.accuracy = INSITU_STANDARD;
  std::int32_t owner_rank = -2;
  args.ranks = &owner_rank;
  EXPECT_EQ(insitu_mesh_locate(solver.mesh->handle(), &args), INSITU_OK) << insitu_last_message();
  EXPECT_EQ(owner_rank, 0);
}

} // namespace

int main(int argc, char** argv) {
  return run_on_all_processes(argc, argv);
}

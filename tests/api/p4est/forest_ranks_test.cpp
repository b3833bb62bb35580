/// A forest over several processes, one of them without a leaf: each is a mesh of its own, and
/// together they have every point once.
#include <cmath>
#include <cstddef>
#include <gtest/gtest.h>
#include <insitu/p4est.h>
#include <p8est_extended.h>
#include <random>
#include <vector>

#include "fixtures/mpi.h"

namespace {

constexpr double trees[3] = {2.0, 1.0, 1.0}; ///< unit cubes

struct Record {
  double rho;
};

double lower(const p8est_quadrant_t* q, p4est_topidx_t tree, int axis) {
  const p4est_qcoord_t at[3] = {q->x, q->y, q->z};
  return (axis == 0 ? double(tree) : 0.0) + double(at[axis]) / P8EST_ROOT_LEN;
}
double width(const p8est_quadrant_t* q) {
  return double(P8EST_QUADRANT_LEN(q->level)) / P8EST_ROOT_LEN;
}

/// A number that no two leaves share.
void number(p8est_t*, p4est_topidx_t tree, p8est_quadrant_t* q) {
  static_cast<Record*>(q->p.user_data)->rho =
      lower(q, tree, 0) + std::sqrt(2.0) * lower(q, tree, 1) + std::sqrt(3.0) * lower(q, tree, 2) +
      std::sqrt(5.0) * width(q);
}
int towards_a_corner(p8est_t*, p4est_topidx_t tree, p8est_quadrant_t* q) {
  return q->level < 1 || (tree == 0 && q->level < 4 && q->x == 0 && q->y == 0 && q->z == 0);
}

/// The number of this process's leaf that holds a point which is on no face; NaN: it has none.
double number_at(const p8est_t* forest, const double* p) {
  for (p4est_topidx_t t = forest->first_local_tree; t >= 0 && t <= forest->last_local_tree; ++t) {
    sc_array_t* const quadrants = &p8est_tree_array_index(forest->trees, t)->quadrants;
    for (std::size_t i = 0; i < quadrants->elem_count; ++i) {
      const auto* const q = static_cast<const p8est_quadrant_t*>(sc_array_index(quadrants, i));
      bool holds = true;
      for (int a = 0; a < 3; ++a)
        holds &= p[a] > lower(q, t, a) && p[a] < lower(q, t, a) + width(q);
      if (holds)
        return static_cast<const Record*>(q->p.user_data)->rho;
    }
  }
  return std::nan("");
}

std::vector<int> sums_of(const std::vector<int>& mine) {
  std::vector<int> all(mine.size());
  EXPECT_EQ(sc_MPI_Allreduce(const_cast<int*>(mine.data()), all.data(), int(mine.size()),
                             sc_MPI_INT, sc_MPI_SUM, sc_MPI_COMM_WORLD),
            sc_MPI_SUCCESS);
  return all;
}
int processes_without_leaves(const p8est_t* forest) {
  return sums_of({forest->local_num_quadrants == 0})[0];
}

struct Forest {
  Forest() {
    connectivity = p8est_connectivity_new_brick(2, 1, 1, 0, 0, 0);
    forest =
        p8est_new_ext(sc_MPI_COMM_WORLD, connectivity, 0, 0, 1, sizeof(Record), number, nullptr);
  }
  ~Forest() {
    p8est_destroy(forest);
    p8est_connectivity_destroy(connectivity);
  }
  Forest(const Forest&) = delete;
  Forest& operator=(const Forest&) = delete;
  p8est_connectivity_t* connectivity;
  p8est_t* forest;
};

/// Commits what the process has, and looks for points there. No step may be left out on one
/// process alone, as the others would wait.
void expect_every_point_once(insitu_session session, p8est_t* forest,
                             insitu_reconstruction reconstruction) {
  insitu_mesh mesh = nullptr;
  EXPECT_EQ(insitu_session_mesh(session, reconstruction == INSITU_DUAL ? "dual" : "nearest", &mesh),
            INSITU_OK);
  EXPECT_EQ(insitu_p4est_mesh_as(mesh, forest, nullptr, nullptr, reconstruction), INSITU_OK)
      << insitu_p4est_message();
  EXPECT_EQ(insitu_p4est_field(mesh, forest, "rho", INSITU_FLOAT64, offsetof(Record, rho), 1),
            INSITU_OK)
      << insitu_p4est_message();
  EXPECT_EQ(insitu_mesh_commit(mesh, nullptr), INSITU_OK) << insitu_last_message();
  constexpr int count = 500;
  std::vector<int> times(count);
  std::mt19937 random(5);
  for (int i = 0; i < count; ++i) {
    double p[3];
    for (int a = 0; a < 3; ++a)
      p[a] = trees[a] * (double(random()) + 0.5) / 4294967296.0;
    double value = 7.0;
    std::int32_t found = -1;
    EXPECT_EQ(insitu_mesh_sample_point(mesh, "rho", p, &value, &found), INSITU_OK)
        << insitu_last_message();
    times[std::size_t(i)] = found;
    const double own = number_at(forest, p);
    EXPECT_EQ(found != 0, !std::isnan(own)) << "seed 5, point " << i;
    if (found != 0 && reconstruction == INSITU_NEAREST) {
      EXPECT_EQ(value, own) << "seed 5, point " << i;
    }
  }
  EXPECT_EQ(sums_of(times), std::vector<int>(count, 1)) << "seed 5";
}

} // namespace

TEST(ForestOverProcesses, EveryPointIsFoundOnce) {
  int processes = 0;
  ASSERT_EQ(sc_MPI_Comm_size(sc_MPI_COMM_WORLD, &processes), sc_MPI_SUCCESS);
  ASSERT_EQ(processes, 3);
  Forest f;
  insitu_session session = nullptr;
  EXPECT_EQ(insitu_session_open(nullptr, &session), INSITU_OK);
  EXPECT_EQ(processes_without_leaves(f.forest), 1); // there are two leaves
  for (int step = 0; step < 2; ++step) {
    for (const auto reconstruction : {INSITU_NEAREST, INSITU_DUAL})
      expect_every_point_once(session, f.forest, reconstruction);
    p8est_refine(f.forest, 1, towards_a_corner, number);
    p8est_balance(f.forest, P8EST_CONNECT_FULL, number);
    p8est_partition(f.forest, 0, nullptr);
  }
  EXPECT_EQ(processes_without_leaves(f.forest), 0);
  EXPECT_EQ(insitu_session_close(&session), INSITU_OK);
}

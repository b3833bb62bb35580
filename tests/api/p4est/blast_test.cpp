/// The adaptive blast, coupled: samples at the centres of p8est's cells are the solver's own
/// values, at every cycle and after every regrid, and only regrids rebuild anything.
#include <cstddef>
#include <gtest/gtest.h>
#include <insitu/insitu.hpp>
#include <insitu/p4est.h>
#include <memory>
#include <vector>

#include "blast.h"
#include "fixtures/mpi.h"

namespace {

struct Coupled : testing::Test {
  void SetUp() override {
    blast_config config = blast_config_default();
    config.finest = 4;
    solver.reset(blast_new(&config, sc_MPI_COMM_SELF));
    ASSERT_NE(solver, nullptr);
    give();
  }
  void give() {
    const double origin[3] = {0, 0, 0}, size[3] = {1, 1, 1};
    p8est_t* const forest = solver->forest;
    ASSERT_EQ(insitu_p4est_mesh(mesh.handle(), forest, origin, size), INSITU_OK)
        << insitu_p4est_message();
    for (const auto& [name, offset, components] :
         {std::tuple{"density", offsetof(blast_cell, density), 1},
          std::tuple{"velocity", offsetof(blast_cell, velocity), 3}})
      ASSERT_EQ(insitu_p4est_field(mesh.handle(), forest, name, INSITU_FLOAT64, offset, components),
                INSITU_OK)
          << insitu_p4est_message();
  }
  std::size_t count() const { return std::size_t(solver->forest->local_num_quadrants); }
  std::vector<double> centres() const {
    std::vector<double> x(3 * count());
    for (std::size_t i = 0; i < count(); ++i)
      blast_centre(solver.get(), i, x.data() + 3 * i);
    return x;
  }
  void expect_the_solvers_values() const {
    const insitu::FieldSamples s =
        mesh.sample_fields({"density", "velocity"}, insitu::Points(centres()));
    for (std::size_t i = 0; i < count(); ++i) {
      const blast_cell& cell = *solver->cells[i];
      ASSERT_TRUE(s.found[i]) << i;
      ASSERT_NEAR(s.values[0].values[i], cell.density, 1e-13) << i;
      for (std::size_t a = 0; a < 3; ++a)
        ASSERT_NEAR(s.values[1].values[3 * i + a], cell.velocity[a], 1e-13) << i;
    }
  }
  insitu::Session session;
  insitu::Mesh mesh = session.mesh("hydro");
  std::unique_ptr<blast_solver, decltype(&blast_free)> solver{nullptr, blast_free};
};

} // namespace

/// Off the centres too, and the checkerboard of the cells: 2 where a face's other cell has another
/// level, else by turns.
TEST_F(Coupled, NearestSamplesAreTheCellsOwn) {
  const double origin[3] = {0, 0, 0}, size[3] = {1, 1, 1};
  insitu::Mesh grid = session.mesh("grid");
  ASSERT_EQ(insitu_p4est_mesh_as(grid.handle(), solver->forest, origin, size, INSITU_NEAREST),
            INSITU_OK)
      << insitu_p4est_message();
  ASSERT_EQ(insitu_p4est_field(grid.handle(), solver->forest, "checkers", INSITU_FLOAT64,
                               offsetof(blast_cell, checkers), 1),
            INSITU_OK)
      << insitu_p4est_message();
  ASSERT_NO_THROW(grid.commit());
  std::vector<double> points = centres();
  for (std::size_t i = 0; i < count(); ++i)
    for (std::size_t a = 0; a < 3; ++a)
      points[3 * i + a] += (double((i + a) % 5) / 5 - 0.4) * solver->work[i].size;
  const insitu::FieldSamples s = grid.sample_fields({"checkers"}, insitu::Points(points));
  // The levels of the cells that hold them.
  const std::vector<std::int32_t> levels = grid.cell_levels(grid.locate(insitu::Points(points)));
  for (std::size_t i = 0; i < count(); ++i)
    ASSERT_EQ(levels[i], solver->cells[i]->level) << i;
  std::vector<int> changes(count(), 0);
  for (std::size_t f = 0; f < solver->face_count; ++f) {
    const blast_face& face = solver->faces[f];
    if (!face.lower || !face.upper)
      continue;
    if (face.lower->level != face.upper->level)
      changes[face.lower->number] = changes[face.upper->number] = 1;
  }
  std::size_t marked = 0;
  for (std::size_t i = 0; i < count(); ++i) {
    const double own = solver->cells[i]->checkers;
    ASSERT_TRUE(s.found[i]) << i;
    ASSERT_EQ(s.values[0].values[i], own) << i;
    ASSERT_EQ(own == 2.0, changes[i] == 1) << i;
    marked += changes[i];
  }
  EXPECT_GT(marked, 0u);
  EXPECT_LT(marked, count());
  for (std::size_t f = 0; f < solver->face_count; ++f) {
    const blast_face& face = solver->faces[f];
    if (face.lower && face.upper && face.lower->checkers < 2 && face.upper->checkers < 2) {
      ASSERT_NE(face.lower->checkers, face.upper->checkers) << f;
    }
  }
}

TEST_F(Coupled, SamplesAtCentresAreTheSolversValues) {
  ASSERT_NO_THROW(mesh.commit());
  expect_the_solvers_values();
  int regrids = 0;
  for (int cycle = 1; cycle <= 16; ++cycle) {
    ASSERT_GT(blast_step(solver.get(), 1.0), 0.0);
    const bool moved = cycle % 4 == 0 && blast_regrid(solver.get()) == 1;
    if (moved)
      give();
    else
      mesh.changed(insitu::fields);
    EXPECT_EQ(mesh.commit().action, moved ? INSITU_REBUILD : INSITU_KEEP) << cycle;
    expect_the_solvers_values();
    regrids += moved;
  }
  EXPECT_GT(regrids, 1);
  EXPECT_EQ(mesh.amr_info().leaves, std::int64_t(count()));
  for (const insitu::AuditEntry& e : mesh.audit())
    EXPECT_TRUE(e.borrowed) << e.name;
}

/// p8est's own search says which quadrant holds a point; `nearest` has to give that quadrant's
/// value.
TEST_F(Coupled, NearestIsTheCellThatHoldsThePoint) {
  insitu_amr amr = insitu_amr_default();
  amr.level_count = 5;
  amr.reconstruction = INSITU_NEAREST;
  ASSERT_EQ(insitu_mesh_amr(mesh.handle(), &amr), INSITU_OK) << insitu_last_message();
  ASSERT_NO_THROW(mesh.commit());
  std::vector<double> x = centres();
  for (std::size_t i = 0; i < count(); ++i) // off the centres, clear of the faces
    for (std::size_t a = 0; a < 3; ++a)
      x[3 * i + a] += 0.49 * solver->work[i].size * (a == i % 3 ? -1.0 : 0.6);
  const insitu::Samples s = mesh.sample("density", insitu::Points(x));
  for (std::size_t i = 0; i < count(); ++i)
    ASSERT_EQ(s.values[i], solver->cells[i]->density) << i;
}

// The adaptive blast miniapp's solver: conservation across hanging faces, uniform flow, symmetry,
// and Sod's tube against the exact solution.
#include <algorithm>
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <memory>
#include <p8est_bits.h>
#include <p8est_extended.h>
#include <utility>

#include "blast.h"
#include "fixtures/mpi.h"
#include "riemann.h"

namespace {

using Solver = std::unique_ptr<blast_solver, decltype(&blast_free)>;

Solver make(const blast_config& config) {
  Solver s(blast_new(&config, sc_MPI_COMM_SELF), blast_free);
  EXPECT_NE(s, nullptr);
  return s;
}

std::size_t count(const Solver& s) {
  return std::size_t(s->forest->local_num_quadrants);
}

void run(const Solver& s, int cycles, int regrid_every = 4) {
  for (int c = 1; c <= cycles; ++c) {
    ASSERT_GT(blast_step(s.get(), 1.0), 0.0);
    if (c % regrid_every == 0) {
      ASSERT_GE(blast_regrid(s.get()), 0);
    }
  }
}

std::pair<double, double> levels(const Solver& s) {
  const auto [low, high] =
      std::minmax_element(s->cells, s->cells + count(s),
                          [](const auto* a, const auto* b) { return a->level < b->level; });
  return {(*low)->level, (*high)->level};
}

/// A ball of high pressure in the middle of a cube.
blast_config centred_ball(int finest) {
  static const blast_ball ball = {{1.0, 1.0, 1.0}, 0.25, 1.0, 10.0, 1.0, 0.1};
  blast_config c = blast_config_default();
  c.trees[0] = 2;
  c.finest = finest;
  c.data = &ball;
  return c;
}

constexpr Riemann::State high{1.0, 0.0, 1.0}, low{0.125, 0.0, 0.1};

/// Sod's tube: four trees along an axis, the membrane in the middle.
void sod(const double x[3], const void* axis, double w[GAS_VALUES]) {
  const Riemann::State& s = x[*static_cast<const int*>(axis)] < 0.5 ? high : low;
  w[0] = s.density;
  w[1] = w[2] = w[3] = 0.0;
  w[4] = s.pressure;
}

} // namespace

TEST(AmrBlastGas, FluxesAreConsistentAndWallsLetNothingThrough) {
  const double w[] = {1.3, 0.4, -0.2, 0.1, 0.7}, still[] = {1.3, 0.0, 0.0, 0.0, 0.7};
  double u[GAS_VALUES], flux[GAS_VALUES];
  gas_conserved(w, 1.4, u);
  for (int axis = 0; axis < 3; ++axis) {
    gas_flux(w, w, axis, 1.4, flux);
    for (int k = 0; k < GAS_VALUES; ++k)
      EXPECT_NEAR(flux[k],
                  w[1 + axis] * (u[k] + (k == 4 ? w[4] : 0.0)) + (k == axis + 1 ? w[4] : 0.0),
                  1e-15);
    gas_flux(still, still, axis, 1.4, flux);
    for (int k = 0; k < GAS_VALUES; ++k)
      EXPECT_NEAR(flux[k], k == axis + 1 ? 0.7 : 0.0, 1e-16);
    for (const int outward : {1, -1}) {
      gas_wall_flux(w, axis, outward, 1.4, flux);
      for (int k = 0; k < GAS_VALUES; ++k)
        if (k != axis + 1) {
          EXPECT_EQ(flux[k], 0.0) << k;
        }
      EXPECT_EQ(flux[axis + 1] > w[4], outward * w[1 + axis] > 0.0);
    }
  }
}

TEST(AmrBlastGas, FluxesOfASupersonicFlowComeFromUpwind) {
  const double left[] = {1.0, 5.0, 1.0, 0.0, 1.0}, right[] = {0.3, 4.0, 0.0, 2.0, 0.4};
  double flux[GAS_VALUES], upwind[GAS_VALUES];
  gas_flux(left, right, 0, 1.4, flux);
  gas_flux(left, left, 0, 1.4, upwind);
  for (int k = 0; k < GAS_VALUES; ++k)
    EXPECT_NEAR(flux[k], upwind[k], 1e-14 * std::fabs(upwind[k]));
}

TEST(AmrBlast, KeepsMassAndEnergyAcrossHangingFacesAndRegrids) {
  for (const int periodic : {0, 1}) {
    blast_config config = blast_config_default();
    config.periodic = periodic;
    config.finest = 4;
    const Solver s = make(config);
    double before[GAS_VALUES], now[GAS_VALUES];
    blast_totals(s.get(), before);
    const std::size_t cells = count(s);
    for (int round = 0; round < 3; ++round) {
      run(s, 24);
      blast_totals(s.get(), now);
      EXPECT_NEAR(now[0] / before[0], 1.0, 1e-14) << periodic;
      EXPECT_NEAR(now[4] / before[4], 1.0, 1e-14) << periodic;
      if (periodic) {
        for (int k = 1; k < 4; ++k)
          EXPECT_NEAR(now[k], 0.0, 1e-12);
      }
      EXPECT_TRUE(p8est_is_balanced(s->forest, P8EST_CONNECT_FULL));
      EXPECT_LT(levels(s).first, levels(s).second);
    }
    EXPECT_NE(count(s), cells);
  }
}

TEST(AmrBlast, UniformFlowStaysUniform) {
  blast_config config = centred_ball(5);
  config.periodic = 1;
  const Solver s = make(config);
  ASSERT_EQ(levels(s), std::make_pair(2.0, 5.0));
  const double w[] = {1.2, 0.3, -0.7, 0.1, 0.8};
  for (std::size_t i = 0; i < count(s); ++i) {
    blast_cell& c = *s->cells[i];
    gas_conserved(w, config.gamma, c.u);
    c.density = w[0];
    std::copy(w + 1, w + 4, c.velocity);
    c.pressure = w[4];
  }
  for (int i = 0; i < 20; ++i)
    ASSERT_GT(blast_step(s.get(), 1.0), 0.0);
  for (std::size_t i = 0; i < count(s); ++i) {
    const blast_cell& c = *s->cells[i];
    ASSERT_NEAR(c.density, w[0], 1e-13);
    ASSERT_NEAR(c.pressure, w[4], 1e-13);
    for (int a = 0; a < 3; ++a)
      ASSERT_NEAR(c.velocity[a], w[1 + a], 1e-13);
  }
  ASSERT_EQ(blast_regrid(s.get()), 1); // nothing jumps
  EXPECT_EQ(levels(s).second, 4.0);
}

TEST(AmrBlast, ABallInTheMiddleStaysSymmetric) {
  const Solver s = make(centred_ball(4));
  run(s, 48);
  std::map<std::array<double, 3>, const blast_cell*> by_centre;
  std::array<double, 3> x;
  for (std::size_t i = 0; i < count(s); ++i) {
    blast_centre(s.get(), i, x.data());
    by_centre[x] = s->cells[i];
  }
  for (const auto& [centre, cell] : by_centre) {
    const auto [px, py, pz] = centre;
    const std::array<double, 3> images[] = {
        {2.0 - px, py, pz}, {px, 2.0 - py, pz}, {px, py, 2.0 - pz}, {py, px, pz}, {px, pz, py}};
    for (const auto& image : images) {
      const auto found = by_centre.find(image);
      ASSERT_NE(found, by_centre.end());
      ASSERT_EQ(found->second->level, cell->level);
      ASSERT_NEAR(found->second->density, cell->density, 1e-12);
      ASSERT_NEAR(found->second->pressure, cell->pressure, 1e-12);
    }
    ASSERT_NEAR(by_centre.at(images[0])->velocity[0], -cell->velocity[0], 1e-12);
    ASSERT_NEAR(by_centre.at(images[3])->velocity[0], cell->velocity[1], 1e-12);
  }
}

/// How far a density that rises linearly is off where the flow has carried it, in the middle of the
/// brick, across levels.
static double profile_error(int order) {
  blast_config config = centred_ball(4);
  config.order = order;
  const Solver s = make(config);
  const auto profile = [](const double x[3], double time) {
    return 2.0 + 0.1 * (x[0] - time) + 0.05 * (x[1] - 0.5 * time);
  };
  double x[3];
  for (std::size_t i = 0; i < count(s); ++i) {
    blast_centre(s.get(), i, x);
    const double w[] = {profile(x, 0.0), 1.0, 0.5, 0.0, 1.0};
    gas_conserved(w, config.gamma, s->cells[i]->u);
    EXPECT_TRUE(blast_update_primitives(s->cells[i], config.gamma));
  }
  for (int i = 0; i < 4; ++i)
    EXPECT_GT(blast_step(s.get(), 1.0), 0.0);
  EXPECT_LT(levels(s).first, levels(s).second);
  double worst = 0.0;
  for (std::size_t i = 0; i < count(s); ++i) {
    blast_centre(s.get(), i, x);
    if (std::all_of(x, x + 3, [](double c) { return c > 0.6 && c < 1.4; }))
      worst = std::max(worst, std::fabs(s->cells[i]->density - profile(x, s->time)));
  }
  return worst;
}

TEST(AmrBlast, LinearProfilesAreCarriedAlongAcrossLevels) {
  const double second = profile_error(2), first = profile_error(1);
  EXPECT_LT(second, 5e-4); // slopes towards a larger neighbour are not exact
  EXPECT_GT(first, 2 * second);
}

TEST(AmrBlast, TheFrontStaysAmongTheFinestCells) {
  const Solver s = make(centred_ball(5));
  run(s, 60);
  for (std::size_t f = 0; f < s->face_count; ++f) {
    const blast_face& face = s->faces[f];
    if (face.lower && face.upper && std::min(face.lower->level, face.upper->level) < 5.0) {
      EXPECT_LT(std::fabs(face.lower->pressure - face.upper->pressure) /
                    std::min(face.lower->pressure, face.upper->pressure),
                2 * s->config.refine);
    }
  }
}

/// The mean error of density over the tube's volume, after a time of 0.2, and how far the state
/// varies across the tube.
static std::pair<double, double> sod_error(int axis, int finest, int order) {
  blast_config config = blast_config_default();
  for (int a = 0; a < 3; ++a)
    config.trees[a] = a == axis ? 4 : 1;
  config.tree_size = 0.25;
  config.finest = finest;
  config.order = order;
  if (order == 1)
    config.courant = 0.8;
  config.initial = sod;
  config.data = &axis;
  const Solver s = make(config);
  constexpr double end = 0.2;
  while (s->time < end) {
    EXPECT_GT(blast_step(s.get(), end - s->time), 0.0);
    if (s->cycle % 4 == 0) {
      EXPECT_GE(blast_regrid(s.get()), 0);
    }
  }
  EXPECT_LT(levels(s).first, levels(s).second);
  const Riemann exact(high, low, config.gamma);
  std::map<double, double> first;
  double error = 0.0, spread = 0.0;
  for (std::size_t i = 0; i < count(s); ++i) {
    double x[3];
    blast_centre(s.get(), i, x);
    const blast_cell& c = *s->cells[i];
    const double size = s->work[i].size, at = x[axis];
    error += size * size * size * std::fabs(c.density - exact.at((at - 0.5) / end).density);
    spread =
        std::max(spread, std::fabs(c.density - first.try_emplace(at, c.density).first->second));
    spread = std::max(spread, std::fabs(c.velocity[(axis + 1) % 3]));
  }
  return {error / (1.0 * 0.25 * 0.25), spread};
}

TEST(AmrBlast, SodsTubeAlongEachAxis) {
  double errors[3];
  for (int axis = 0; axis < 3; ++axis) {
    // 64 cells along the tube where it is finest.
    const auto [error, spread] = sod_error(axis, 4, 2);
    EXPECT_LT(error, 0.013) << axis;
    EXPECT_LT(spread, 1e-12) << axis;
    errors[axis] = error;
  }
  EXPECT_NEAR(errors[1], errors[0], 1e-12);
  EXPECT_NEAR(errors[2], errors[0], 1e-12);
  EXPECT_LT(errors[0], 0.65 * sod_error(0, 3, 2).first); // jumps keep it from a quarter
  const double first_order = sod_error(0, 4, 1).first;
  EXPECT_LT(first_order, 0.03);
  EXPECT_GT(first_order, 1.5 * errors[0]);
}

TEST(AmrBlast, ConfigurationsOfNoSenseMakeNoSolver) {
  blast_config c = blast_config_default();
  c.finest = c.coarsest - 1;
  EXPECT_EQ(blast_new(&c, sc_MPI_COMM_SELF), nullptr);
  c = blast_config_default();
  c.courant = 1.5;
  EXPECT_EQ(blast_new(&c, sc_MPI_COMM_SELF), nullptr);
  static const blast_ball hollow = {{1.0, 1.0, 1.0}, 0.25, 1.0, -1.0, 1.0, 0.1};
  c = blast_config_default();
  c.data = &hollow;
  EXPECT_EQ(blast_new(&c, sc_MPI_COMM_SELF), nullptr);
}

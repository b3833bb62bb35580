// The blast wave miniapp's kernels of the hexahedral cell and its similarity solution.
#include <array>
#include <cmath>
#include <gtest/gtest.h>
#include <random>
#include <stdexcept>

#include "hexahedron.h"
#include "sedov_cell.h"
#include "sedov_taylor.h"

namespace {

using sedov::Corners;
using sedov::SedovTaylor;

Cell jittered_cell(std::mt19937& generator, double jitter) {
  std::uniform_real_distribution<double> offset(-jitter, jitter);
  Cell cell{};
  for (int b = 0; b < 8; ++b) {
    cell.x[b] = (b & 1) + offset(generator);
    cell.y[b] = (b >> 1 & 1) + offset(generator);
    cell.z[b] = (b >> 2 & 1) + offset(generator);
  }
  return cell;
}

// ---- the cell's kernels

TEST(SedovHexahedron, VolumeIsThatOfTheTrilinearMap) {
  // The Jacobian is quadratic at most in each reference coordinate: two Gauss points are exact.
  std::mt19937 generator(1);
  for (int trial = 0; trial < 100; ++trial) {
    const Cell cell = jittered_cell(generator, 0.4);
    double expected = 0.0;
    for (int point = 0; point < 8; ++point) {
      double at[3], jacobian[3][3] = {};
      for (int d = 0; d < 3; ++d)
        at[d] = 0.5 + (point & (1 << d) ? 0.5 : -0.5) / std::sqrt(3.0);
      for (int b = 0; b < 8; ++b)
        for (int d = 0; d < 3; ++d) {
          double slope = 1.0;
          for (int e = 0; e < 3; ++e) {
            const bool high = b & (1 << e);
            slope *= e == d ? (high ? 1.0 : -1.0) : (high ? at[e] : 1.0 - at[e]);
          }
          jacobian[0][d] += cell.x[b] * slope;
          jacobian[1][d] += cell.y[b] * slope;
          jacobian[2][d] += cell.z[b] * slope;
        }
      const auto& j = jacobian;
      expected += (j[0][0] * (j[1][1] * j[2][2] - j[1][2] * j[2][1]) -
                   j[0][1] * (j[1][0] * j[2][2] - j[1][2] * j[2][0]) +
                   j[0][2] * (j[1][0] * j[2][1] - j[1][1] * j[2][0])) /
                  8.0;
    }
    EXPECT_NEAR(volume_of(cell), expected, 1e-14);
  }
}

TEST(SedovHexahedron, VolumeGradientAgreesWithDifferences) {
  std::mt19937 generator(2);
  for (int trial = 0; trial < 100; ++trial) {
    Cell cell = jittered_cell(generator, 0.4);
    Corners gradient[3];
    sedov::volume_gradient(cell.x, cell.y, cell.z, gradient[0], gradient[1], gradient[2]);
    Corners* const coordinates[3] = {&cell.x, &cell.y, &cell.z};
    for (int d = 0; d < 3; ++d) {
      double sum = 0.0;
      for (int b = 0; b < 8; ++b) {
        // The volume is linear in each single coordinate: a difference of any width is exact.
        double& coordinate = (*coordinates[d])[b];
        const double at = coordinate;
        coordinate = at + 0.5;
        const double above = volume_of(cell);
        coordinate = at - 0.5;
        const double below = volume_of(cell);
        coordinate = at;
        EXPECT_NEAR(gradient[d][b], above - below, 1e-14);
        sum += gradient[d][b];
      }
      EXPECT_NEAR(sum, 0.0, 1e-15) << "a closed surface pushes itself along axis " << d;
    }
  }
}

TEST(SedovHexahedron, ModesAndTheirTransposeAreEightTimesTheIdentity) {
  std::mt19937 generator(3);
  const Cell cell = jittered_cell(generator, 0.4);
  Corners values = cell.x;
  sedov::to_modes(values);
  EXPECT_NEAR(
      values[0],
      [&] {
        double sum = 0.0;
        for (double value : cell.x)
          sum += value;
        return sum;
      }(),
      1e-14);
  sedov::from_modes(values);
  for (int b = 0; b < 8; ++b)
    EXPECT_NEAR(values[b], 8.0 * cell.x[b], 1e-14);

  Corners mode{}; // 5: the product of the first and the third coordinate
  mode[5] = 1.0;
  sedov::from_modes(mode);
  for (int b = 0; b < 8; ++b)
    EXPECT_EQ(mode[b], (b & 1 ? 1.0 : -1.0) * (b & 4 ? 1.0 : -1.0));
}

TEST(SedovHexahedron, LowestEigenvalueSolvesItsEquation) {
  std::mt19937 generator(4);
  std::uniform_real_distribution<double> entry(-1.0, 1.0);
  for (int trial = 0; trial < 1000; ++trial) {
    std::array<double, 6> m;
    for (double& value : m)
      value = entry(generator);
    const auto [xx, yy, zz, yz, xz, xy] = m;
    std::array<double, 3> n;
    const double lowest = sedov::lowest_eigenvalue(m, n);
    EXPECT_NEAR(xx * n[0] + xy * n[1] + xz * n[2], lowest * n[0], 1e-11);
    EXPECT_NEAR(xy * n[0] + yy * n[1] + yz * n[2], lowest * n[1], 1e-11);
    EXPECT_NEAR(xz * n[0] + yz * n[1] + zz * n[2], lowest * n[2], 1e-11);
    EXPECT_NEAR(std::hypot(n[0], n[1], n[2]), 1.0, 1e-14);
    // No direction has less.
    for (int other = 0; other < 20; ++other) {
      const double a = entry(generator), b = entry(generator), c = entry(generator);
      const double form =
          xx * a * a + yy * b * b + zz * c * c + 2.0 * (yz * b * c + xz * a * c + xy * a * b);
      EXPECT_GE(form, (lowest - 1e-11) * (a * a + b * b + c * c));
    }
  }
}

// ---- the similarity solution

TEST(SedovTaylorSolution, AlphaIsThePublishedOne) {
  // Kamm and Timmes, LA-UR-07-2849, gamma 1.4, spherical; and the known value at 5/3.
  EXPECT_NEAR(SedovTaylor(1.4, 1.0, 1.0).alpha(), 0.851072, 1e-5);
  EXPECT_NEAR(SedovTaylor(5.0 / 3.0, 1.0, 1.0).alpha(), 0.4936, 1e-4);
  EXPECT_THROW(SedovTaylor(1.0, 1.0, 1.0), std::invalid_argument);
  EXPECT_THROW(SedovTaylor(7.0, 1.0, 1.0), std::invalid_argument);
  EXPECT_THROW(SedovTaylor(1.4, 0.0, 1.0), std::invalid_argument);
}

TEST(SedovTaylorSolution, HoldsItsMassAndEnergyAtAnyGamma) {
  for (double gamma : {1.1, 1.4, 5.0 / 3.0, 2.0, 3.0, 6.5}) {
    const double energy = 3.0, ahead = 0.7, time = 0.4;
    const SedovTaylor solution(gamma, energy, ahead);
    const double shock = solution.shock_radius(time);
    EXPECT_NEAR(solution.shock_time(shock), time, 1e-14);
    double mass = 0.0, total = 0.0;
    constexpr int shells = 40000;
    for (int i = 0; i < shells; ++i) {
      const double r = shock * (i + 0.5) / shells;
      const double volume = 4.0 * std::acos(-1.0) * r * r * shock / shells;
      const SedovTaylor::State state = solution.at(r, time);
      mass += volume * state.density;
      total += volume * (0.5 * state.density * state.velocity * state.velocity +
                         state.pressure / (gamma - 1.0));
    }
    const double swept = 4.0 / 3.0 * std::acos(-1.0) * shock * shock * shock * ahead;
    EXPECT_NEAR(mass / swept, 1.0, 1e-4) << "gamma " << gamma;
    EXPECT_NEAR(total / energy, 1.0, 1e-4) << "gamma " << gamma;
  }
}

TEST(SedovTaylorSolution, SolvesTheEulerEquations) {
  for (double gamma : {1.4, 2.0}) {
    const SedovTaylor solution(gamma, 1.0, 1.0);
    const double time = 1.0, shock = solution.shock_radius(time);
    for (double part : {0.3, 0.5, 0.7, 0.9, 0.97}) {
      const double r = part * shock, h = 1e-4 * r, k = 1e-4;
      const auto state = solution.at(r, time);
      const auto in = solution.at(r - h, time), out = solution.at(r + h, time);
      const auto before = solution.at(r, time - k), after = solution.at(r, time + k);
      const auto d_r = [&](auto member) { return (out.*member - in.*member) / (2.0 * h); };
      const auto d_t = [&](auto member) { return (after.*member - before.*member) / (2.0 * k); };
      using State = SedovTaylor::State;
      const double rho = state.density, p = state.pressure, v = state.velocity;
      const double continuity = d_t(&State::density) + v * d_r(&State::density) +
                                rho * (d_r(&State::velocity) + 2.0 * v / r);
      const double momentum =
          rho * (d_t(&State::velocity) + v * d_r(&State::velocity)) + d_r(&State::pressure);
      const double entropy = d_t(&State::pressure) + v * d_r(&State::pressure) -
                             gamma * p / rho * (d_t(&State::density) + v * d_r(&State::density));
      EXPECT_NEAR(continuity / (rho * v / r), 0.0, 1e-4) << part;
      EXPECT_NEAR(momentum / (rho * v * v / r), 0.0, 1e-4) << part;
      EXPECT_NEAR(entropy / (p * v / r), 0.0, 1e-4) << part;
    }
  }
}

} // namespace

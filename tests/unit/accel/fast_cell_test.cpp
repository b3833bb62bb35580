// The cell kernels of `fast` on a device, as plain code, against exact containment and Newton's
// method in double.
#include <cmath>
#include <gtest/gtest.h>

#include "cells/exact/contain_exact.h"
#include "cells/kernels/kernels.h"
#include "fixtures/cells.h"
#include "query/device/fast_cell.h"

using namespace insitu;
using math::Vec3d;
using mesh::Shape;
using query::on_device::fast_inverse;
using query::on_device::fast_margin;
using query::on_device::FastMap;

namespace {

/// Of parametric coordinates in cells of about unit size: coordinates relative to the point are
/// rounded to 2^-24 of a unit or so, the residual adds up some twenty of these, and the inverse of
/// the Jacobian stretches them by up to 10 at this jitter; the last Newton step leaves the square
/// of 2e-4.
constexpr double tolerance = 2e-5;
constexpr double jitter = 0.15;

FastMap fast(Shape shape, const std::vector<Vec3d>& cell, const Vec3d& p) {
  math::Vec3f x[8];
  for (std::size_t v = 0; v < cell.size(); ++v) {
    const Vec3d d = cell[v] - p;
    x[v] = {float(d.x), float(d.y), float(d.z)};
  }
  return fast_inverse(shape, x);
}

/// Random cells, at an offset and in a scale that the differences to the point take away.
std::vector<Vec3d> random_cell(Shape shape, std::uint64_t item, double offset, double scale) {
  std::vector<Vec3d> x = shape == Shape::voxel ? fixtures::reference_corners(shape)
                                               : fixtures::jittered_cell(shape, jitter, 5, item);
  for (Vec3d& p : x)
    p = scale * p + Vec3d{offset, -offset, offset};
  return x;
}

} // namespace

TEST(FastCell, FindsTheCoordinatesOfPointsInTheCell) {
  for (const Shape shape : fixtures::all_shapes)
    for (const auto& [offset, scale] : {std::pair{0.0, 1.0}, {1e5, 1.0}, {0.0, 1e-3}, {1e3, 1e3}}) {
      double worst = 0;
      for (std::uint64_t i = 0; i < 2000; ++i) {
        const std::vector<Vec3d> cell = random_cell(shape, i, offset, scale);
        const Vec3d r = fixtures::random_parametric(shape, 6, i);
        const Vec3d p = cells::map_to_physical(shape, cell.data(), r);
        const FastMap map = fast(shape, cell, p);
        // At the pyramid's apex all r and s are one point.
        const double shrink = shape == Shape::pyramid ? 1 - r.z : 1;
        ASSERT_TRUE(std::isfinite(map.margin)) << int(shape) << ", cell " << i;
        worst =
            std::max({worst, shrink * std::fabs(double(map.r.x) - r.x),
                      shrink * std::fabs(double(map.r.y) - r.y), std::fabs(double(map.r.z) - r.z)});
      }
      EXPECT_LT(worst, tolerance) << int(shape) << ", offset " << offset << ", scale " << scale;
    }
}

TEST(FastCell, TellsInsideFromOutside) {
  for (const Shape shape : fixtures::all_shapes) {
    int inside = 0, outside = 0, unsure = 0;
    for (std::uint64_t i = 0; i < 20000; ++i) {
      const std::vector<Vec3d> cell = random_cell(shape, i, 0, 1);
      Vec3d p; // about the cell, half of them beyond it
      for (int a = 0; a < 3; ++a)
        p[a] = 1.6 * core::random_unit(7, i, std::uint64_t(a)) - 0.3;
      const bool holds = cells::holds(cells::contain_exact(shape, cell.data(), p).where);
      const auto map = cells::inverse_map(shape, cell.data(), p);
      if (map.converged && std::fabs(map.margin) < tolerance) {
        ++unsure;
        continue;
      }
      const bool told = fast(shape, cell, p).margin >= fast_margin; // NaN: no
      ASSERT_EQ(told, holds) << int(shape) << ", cell " << i << ", margin " << map.margin;
      ++(holds ? inside : outside);
    }
    EXPECT_GT(inside, 600) << int(shape); // tetrahedra hold a sixth of a cube
    EXPECT_GT(outside, 5000) << int(shape);
    EXPECT_LT(unsure, 20) << int(shape);
  }
}

TEST(FastCell, KeepsPointsOnTheBoundary) {
  // Within rounding of a face: the margin is about nothing, whichever side float finds.
  for (const Shape shape : fixtures::all_shapes)
    for (std::uint64_t i = 0; i < 2000; ++i) {
      const std::vector<Vec3d> cell = random_cell(shape, i, 0, 1);
      Vec3d r = fixtures::random_parametric(shape, 8, i);
      r[int(i % 3)] = 0; // a face of every shape's reference cell
      const Vec3d p = cells::map_to_physical(shape, cell.data(), r);
      ASSERT_NEAR(fast(shape, cell, p).margin, 0, tolerance) << int(shape) << ", cell " << i;
    }
}

TEST(FastCell, FindsNothingWhereThereIsNothing) {
  const double nan = std::nan("");
  for (const Shape shape : fixtures::all_shapes) {
    const std::vector<Vec3d> cell = random_cell(shape, 1, 0, 1);
    for (const Vec3d& p :
         {Vec3d{nan, 0.5, 0.5}, Vec3d{0.5, 0.5, HUGE_VAL}, Vec3d{1e30, 0, 0}, Vec3d{-5, 3, 100}})
      EXPECT_FALSE(fast(shape, cell, p).margin >= fast_margin) << int(shape);
    std::vector<Vec3d> flat = cell; // without volume
    for (Vec3d& x : flat)
      x.z = 0;
    EXPECT_FALSE(fast(shape, flat, {0.3, 0.3, 0.5}).margin >= fast_margin) << int(shape);
  }
}

TEST(FastCell, ThePyramidsApexIsInTheCell) {
  for (std::uint64_t i = 0; i < 100; ++i) {
    const std::vector<Vec3d> cell = random_cell(Shape::pyramid, i, 0, 1);
    const FastMap map = fast(Shape::pyramid, cell, cell[4]);
    EXPECT_NEAR(map.r.z, 1, tolerance);
    EXPECT_TRUE(std::isfinite(map.r.x) && std::isfinite(map.r.y));
    EXPECT_GE(map.margin, -tolerance);
  }
}

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

#include "cells/exact/robust_inverse.h"
#include "cells/kernels/kernels.h"
#include "cells/kernels/kernels_simd.h"
#include "fixtures/cells.h"
#include "mesh/piece.h"

using namespace insitu;
using fixtures::all_shapes;
using math::Vec3d;
using mesh::Shape;

TEST(ShapeFunctions, AreOneAtTheirVertexAndSumToOne) {
  for (const Shape shape : all_shapes) {
    std::vector<Vec3d> corners = fixtures::reference_corners(shape);
    if (shape == Shape::pyramid)
      corners[4] = {0.3, 0.9, 1}; // any r, s
    for (std::size_t v = 0; v < corners.size(); ++v) {
      double n[8];
      cells::shape_functions(shape, corners[v], n);
      for (std::size_t w = 0; w < corners.size(); ++w)
        EXPECT_EQ(n[w], v == w ? 1.0 : 0.0) << mesh::shape_name(shape) << v << w;
    }
    for (std::uint64_t i = 0; i < 100; ++i) {
      double n[8], sum = 0;
      cells::shape_functions(shape, fixtures::random_parametric(shape, 1, i), n);
      for (std::size_t w = 0; w < corners.size(); ++w)
        sum += n[w];
      EXPECT_NEAR(sum, 1.0, 1e-15);
    }
  }
}

// Central differences of a polynomial of degree at most 3 per axis: exact to h^2, so to 1e-9.
TEST(ShapeFunctions, DerivativesAreThoseOfTheFunctions) {
  constexpr double h = 1e-5;
  for (const Shape shape : all_shapes)
    for (std::uint64_t i = 0; i < 50; ++i) {
      const Vec3d r = fixtures::random_parametric(shape, 2, i);
      Vec3d d[8];
      cells::shape_derivatives(shape, r, d);
      for (int a = 0; a < 3; ++a) {
        Vec3d lo = r, hi = r;
        lo[a] -= h;
        hi[a] += h;
        double nl[8], nh[8];
        cells::shape_functions(shape, lo, nl);
        cells::shape_functions(shape, hi, nh);
        for (int v = 0; v < mesh::vertex_count(shape); ++v)
          EXPECT_NEAR(d[v][a], (nh[v] - nl[v]) / (2 * h), 1e-9);
      }
    }
}

// Newton errs by rounding times the map's condition; jitter 0.2 keeps that below about 1e3.
TEST(InverseMap, ReturnsToTheParametricPoint) {
  for (const Shape shape : all_shapes) {
    const double jitter = shape == Shape::voxel ? 0.0 : 0.2;
    for (std::uint64_t i = 0; i < 5000; ++i) {
      std::vector<Vec3d> x = fixtures::jittered_cell(shape, jitter, 3, i);
      const Vec3d r = fixtures::random_parametric(shape, 4, i);
      const Vec3d p = cells::map_to_physical(shape, x.data(), r);
      const auto map = cells::inverse_map(shape, x.data(), p);
      ASSERT_TRUE(map.converged) << mesh::shape_name(shape) << " seed 3, cell " << i;
      ASSERT_GE(map.margin, -1e-12) << mesh::shape_name(shape) << " seed 3, cell " << i;
      const Vec3d back = cells::map_to_physical(shape, x.data(), map.r);
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(back[c], p[c], 4e-15) << mesh::shape_name(shape) << " seed 3, cell " << i;
    }
  }
}

TEST(InverseMap, IsSafeAtAPyramidsApexAndOnFlatCells) {
  std::vector<Vec3d> x = fixtures::jittered_cell(Shape::pyramid, 0.2, 5, 1);
  const auto apex = cells::inverse_map(Shape::pyramid, x.data(), x[4]);
  EXPECT_TRUE(apex.converged);
  EXPECT_EQ(apex.r.z, 1.0);
  const Vec3d near = x[4] + 1e-9 * (x[0] + x[2] - x[4] - x[4]);
  const auto below = cells::inverse_map(Shape::pyramid, x.data(), near);
  EXPECT_TRUE(below.converged);
  EXPECT_GT(below.margin, 0.0);

  for (const Shape shape : all_shapes) { // no volume at all: bounded, not converged, no NaN
    std::vector<Vec3d> flat(8, Vec3d{1, 2, 3});
    const auto map = cells::inverse_map(shape, flat.data(), Vec3d{1, 2, 4});
    EXPECT_FALSE(map.converged && map.margin >= 0) << mesh::shape_name(shape);
  }
}

TEST(InverseMap, RobustInverseFindsPointsOfCollapsedHexahedra) {
  // A hexahedron whose edge 3-7 fell on 0-4: a wedge, singular along that edge.
  std::vector<Vec3d> x = fixtures::reference_corners(Shape::hexahedron);
  x[3] = x[0];
  x[7] = x[4];
  for (std::uint64_t i = 0; i < 200; ++i) {
    const Vec3d r = fixtures::random_parametric(Shape::hexahedron, 6, i);
    const Vec3d p = cells::map_to_physical(Shape::hexahedron, x.data(), r);
    const Vec3d found = cells::robust_inverse(Shape::hexahedron, x.data(), p);
    const Vec3d e = cells::map_to_physical(Shape::hexahedron, x.data(), found) - p;
    EXPECT_LT(std::sqrt(dot(e, e)), 1e-12) << "seed 6, point " << i;
  }
}

TEST(Gradient, OfALinearFieldIsExactInEveryShape) {
  const Vec3d g{1.5, -2.0, 0.25};
  for (const Shape shape : all_shapes)
    for (std::uint64_t i = 0; i < 200; ++i) {
      const auto x = fixtures::jittered_cell(shape, shape == Shape::voxel ? 0 : 0.2, 7, i);
      double f[8];
      for (std::size_t v = 0; v < x.size(); ++v)
        f[v] = dot(g, x[v]);
      Vec3d r = fixtures::random_parametric(shape, 8, i);
      r.z *= 0.9; // the pyramid's gradient at its apex is undefined
      const Vec3d found = cells::gradient(shape, x.data(), f, r);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(found[c], g[c], 1e-11) << mesh::shape_name(shape) << " seed 7, cell " << i;
    }
}

TEST(Kernels, FloatInstantiationAgreesToItsPrecision) {
  for (const Shape shape : all_shapes)
    for (std::uint64_t i = 0; i < 200; ++i) {
      const auto x = fixtures::jittered_cell(shape, shape == Shape::voxel ? 0 : 0.1, 9, i);
      std::vector<math::Vec3f> xf;
      for (const Vec3d& v : x)
        xf.push_back({float(v.x), float(v.y), float(v.z)});
      const Vec3d r = fixtures::random_parametric(shape, 10, i);
      const math::Vec3f rf{float(r.x), float(r.y), float(r.z)};
      const Vec3d p = cells::map_to_physical(shape, x.data(), r);
      const math::Vec3f pf = cells::map_to_physical(shape, xf.data(), rf);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(pf[c], p[c], 2e-6);
      const auto g = cells::gradient(shape, xf.data(), std::array<float, 8>{}.data(), rf);
      EXPECT_EQ(g.x, 0.0f);
    }
}

HWY_BEFORE_NAMESPACE();
namespace insitu::test_pack {
namespace simd = cells::HWY_NAMESPACE;
namespace hn = hwy::HWY_NAMESPACE;
using simd::Pack;

HWY_ATTR void invert_pack(Shape shape, const double* vertices, const double* points, double* out) {
  const simd::PackTag d;
  const auto load = [&](const double* p) HWY_ATTR { return Pack(hn::LoadU(d, p)); };
  simd::Vec3<Pack> x[8];
  for (int v = 0; v < mesh::vertex_count(shape); ++v)
    x[v] = {load(vertices + (3 * v) * 8), load(vertices + (3 * v + 1) * 8),
            load(vertices + (3 * v + 2) * 8)};
  const simd::Vec3<Pack> p{load(points), load(points + 8), load(points + 16)};
  const auto map = simd::inverse_map(shape, x, p);
  hn::StoreU(map.r.x.v, d, out);
  hn::StoreU(map.r.y.v, d, out + 8);
  hn::StoreU(map.r.z.v, d, out + 16);
  hn::StoreU(map.margin.v, d, out + 24);
  // The other kernels' instantiations.
  Pack f[8];
  for (auto& v : f)
    v = Pack(2.0);
  const auto g = simd::gradient(shape, x, f, map.r);
  hn::StoreU(g.x.v, d, out + 32);
}
int pack_lanes() {
  return int(hn::Lanes(simd::PackTag()));
}
} // namespace insitu::test_pack
HWY_AFTER_NAMESPACE();

TEST(Kernels, APackGivesTheBitsOfScalars) {
  for (const Shape shape : all_shapes)
    for (std::uint64_t i = 0; i < 500; ++i) {
      double vertices[8 * 3 * 8], points[24], out[40];
      std::vector<std::vector<Vec3d>> x;
      std::vector<Vec3d> p;
      for (std::uint64_t lane = 0; lane < 8; ++lane) {
        x.push_back(fixtures::jittered_cell(shape, 0.3, 11, 8 * i + lane));
        p.push_back(cells::map_to_physical(shape, x.back().data(),
                                           fixtures::random_parametric(shape, 12, 8 * i + lane)));
        if (lane % 3 == 0)
          p.back().x += 0.7; // outside as well
        for (std::size_t v = 0; v < x.back().size(); ++v)
          for (std::size_t c = 0; c < 3; ++c)
            vertices[(3 * v + c) * 8 + lane] = x.back()[v][int(c)];
        for (std::size_t c = 0; c < 3; ++c)
          points[c * 8 + lane] = p.back()[int(c)];
      }
      test_pack::invert_pack(shape, vertices, points, out);
      for (int lane = 0; lane < test_pack::pack_lanes(); ++lane) {
        const auto l = std::size_t(lane);
        const auto map = cells::inverse_map(shape, x[l].data(), p[l]);
        const double scalar[4] = {map.r.x, map.r.y, map.r.z, map.margin};
        for (std::size_t c = 0; c < 4; ++c)
          ASSERT_EQ(std::memcmp(&scalar[c], &out[8 * c + l], 8), 0)
              << mesh::shape_name(shape) << " seed 11, cell " << 8 * i + l;
        ASSERT_EQ(out[32 + l], 0.0);
      }
    }
}

/// What a face-based (polyhedral) piece will fill in: the four calls of the cell interface.
struct PolyhedralStub {
  std::vector<std::vector<std::int64_t>> cells;
  std::vector<Vec3d> points;
  Shape shape(std::int64_t) const { return Shape::hexahedron; }
  int vertex_ids(std::int64_t cell, std::int64_t* ids) const {
    std::copy(cells[std::size_t(cell)].begin(), cells[std::size_t(cell)].end(), ids);
    return int(cells[std::size_t(cell)].size());
  }
  Vec3d point(std::int64_t id) const { return points[std::size_t(id)]; }
  bool owns(std::int64_t) const { return true; }
};
static_assert(mesh::CellSource<PolyhedralStub>);
static_assert(mesh::CellSource<mesh::PieceView>);

template <mesh::CellSource C>
cells::InverseMap<double> invert_in(const C& source, std::int64_t cell, const Vec3d& p) {
  std::int64_t ids[8];
  Vec3d x[8];
  const int n = source.vertex_ids(cell, ids);
  for (int v = 0; v < n; ++v)
    x[v] = source.point(ids[v]);
  return cells::inverse_map(source.shape(cell), x, p);
}

TEST(Kernels, WorkThroughTheCellInterfaceOfAFaceBasedPiece) {
  const PolyhedralStub stub{{{0, 1, 2, 3, 4, 5, 6, 7}},
                            fixtures::reference_corners(Shape::hexahedron)};
  const auto map = invert_in(stub, 0, {0.25, 0.5, 0.75});
  EXPECT_TRUE(map.converged);
  EXPECT_NEAR(map.r.z, 0.75, 1e-15);
}

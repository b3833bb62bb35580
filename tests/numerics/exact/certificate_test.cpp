/// The inverse map's certificate, and how well its answer maps back, against 50-digit arithmetic.

#include <boost/multiprecision/cpp_bin_float.hpp>
#include <cstring>
#include <gtest/gtest.h>

#include "cases.h"
#include "cells/exact/contain_exact.h"
#include "fixtures/simd_targets.h"
#include "lanes.h"

namespace insitu::test {
namespace {

using Real = boost::multiprecision::cpp_bin_float_50;
using RealVec = std::array<Real, 3>;

RealVec cross(const RealVec& a, const RealVec& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Real dot(const RealVec& a, const RealVec& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/// The cell's map and its derivatives, in shape functions and so in another form than the
/// library's. A pyramid's coordinates are (u, v, w) = (1-t) (r, s, 1): weights u v / w and so on.
struct ExactMap {
  Shape shape;
  std::array<RealVec, 8> x;

  ExactMap(Shape s, const Vertices& v) : shape(s) {
    for (std::size_t i = 0; i < 8; ++i)
      x[i] = {Real(v[i].x), Real(v[i].y), Real(v[i].z)};
  }

  /// Weights (column 0) and their derivatives.
  std::array<std::array<Real, 4>, 8> weights(const RealVec& q) const {
    std::array<std::array<Real, 4>, 8> n{};
    const Real &r = q[0], &s = q[1], &t = q[2];
    switch (shape) {
    case Shape::tetrahedron:
      return {{{1 - r - s - t, -1, -1, -1}, {r, 1, 0, 0}, {s, 0, 1, 0}, {t, 0, 0, 1}}};
    case Shape::wedge: {
      const Real p = 1 - r - s, m = 1 - t;
      return {{{p * m, -m, -m, -p},
               {r * m, m, 0, -r},
               {s * m, 0, m, -s},
               {p * t, -t, -t, p},
               {r * t, t, 0, r},
               {s * t, 0, t, s}}};
    }
    case Shape::pyramid: { // r, s, t are u, v, w here
      const Real a = r / t, b = s / t, ab = a * b;
      return {{{t - r - s + t * ab, b - 1, a - 1, 1 - ab},
               {r - t * ab, 1 - b, -a, ab},
               {t * ab, b, a, -ab},
               {s - t * ab, -b, 1 - a, ab},
               {1 - t, 0, 0, -1}}};
    }
    default: {
      const int swap = shape == Shape::voxel ? 1 : 0;
      for (int k = 0; k < 8; ++k) {
        const bool i = (k & 1) != 0, j = (k & 2) != 0, l = (k & 4) != 0;
        const Real u = i ? r : 1 - r, v = j ? s : 1 - s, w = l ? t : 1 - t;
        const int vertex = swap ? k : (k & 4) + (j ? (i ? 2 : 3) : (i ? 1 : 0));
        n[std::size_t(vertex)] = {u * v * w, (i ? 1 : -1) * v * w, (j ? 1 : -1) * u * w,
                                  (l ? 1 : -1) * u * v};
      }
      return n;
    }
    }
  }

  /// x(q) - p and the columns of the Jacobian.
  std::array<RealVec, 4> evaluate(const RealVec& q, const Vec3d& p) const {
    std::array<RealVec, 4> out{};
    const auto n = weights(q);
    for (std::size_t v = 0; v < std::size_t(mesh::vertex_count(shape)); ++v)
      for (std::size_t k = 0; k < 4; ++k)
        for (std::size_t a = 0; a < 3; ++a)
          out[k][a] += n[v][k] * x[v][a];
    for (int a = 0; a < 3; ++a)
      out[0][std::size_t(a)] -= Real(p[a]);
    return out;
  }

  Real margin(const RealVec& q) const {
    const Real &r = q[0], &s = q[1], &t = q[2];
    switch (shape) {
    case Shape::tetrahedron:
      return std::min({r, s, t, Real(1 - r - s - t)});
    case Shape::wedge:
      return std::min({r, s, Real(1 - r - s), t, Real(1 - t)});
    case Shape::pyramid:
      return std::min({r, Real(t - r), s, Real(t - s), t, Real(1 - t)});
    default:
      return std::min({r, Real(1 - r), s, Real(1 - s), t, Real(1 - t)});
    }
  }

  /// The coordinates that this map takes, of VTK's.
  RealVec from_vtk(const Vec3d& r) const {
    if (shape != Shape::pyramid)
      return {Real(r.x), Real(r.y), Real(r.z)};
    const Real w = 1 - Real(r.z);
    return {w * Real(r.x), w * Real(r.y), w};
  }

  /// The preimage near r: Newton until the step is far below a double's rounding.
  RealVec solve(const Vec3d& r, const Vec3d& p) const {
    RealVec q = from_vtk(r);
    for (int i = 0; i < 6; ++i) {
      const auto [f, a, b, c] = evaluate(q, p);
      const RealVec bc = cross(b, c);
      const Real det = dot(a, bc);
      const RealVec step{dot(f, bc) / det, dot(f, cross(c, a)) / det, dot(f, cross(a, b)) / det};
      for (std::size_t k = 0; k < 3; ++k)
        q[k] -= step[k];
    }
    return q;
  }
};

struct Kind {
  const char* name;
  double jitter, offset;
  Vec3d scale;
  double shear; ///< along x by z, in cells: slivers that no axis is aligned with
};
constexpr Kind kinds[] = {
    {"aligned", 0.0, 0.0, {1, 1, 1}, 0.0},      {"jitter 0.2", 0.2, 0.0, {1, 1, 1}, 0.0},
    {"jitter 0.4", 0.4, 0.0, {1, 1, 1}, 0.0},   {"offset 1e7", 0.2, 1e7, {1, 1, 1}, 0.0},
    {"aspect 1e6", 0.2, 0.0, {1e6, 1, 1}, 0.0}, {"aspect 1e6 at 1e7", 0.2, 1e7, {1, 1e6, 1e3}, 0.0},
    {"slivers", 0.2, 0.0, {1, 1, 1}, 1e4},      {"tiny", 0.2, 0.0, {1e-30, 1e-30, 1e-30}, 0.0},
};

Vertices make_cell(Shape shape, const Kind& kind, Random& random) {
  Vertices v = unit_cell(shape);
  if (shape == Shape::wedge) // the order of the shape functions, so that r, s, t turn right
    std::swap(v[1], v[2]), std::swap(v[4], v[5]);
  for (Vec3d& p : v) {
    p += random.uniform({-kind.jitter, -kind.jitter, -kind.jitter},
                        {kind.jitter, kind.jitter, kind.jitter});
    p.x += kind.shear * p.z;
    for (int a = 0; a < 3; ++a)
      p[a] = kind.offset + kind.scale[a] * p[a];
  }
  return v;
}

Vec3d point_in_box(Shape shape, const Vertices& v, Random& random) {
  const auto [low, high] = bounds_of(shape, v.data());
  return random.uniform(low, high);
}

/// Anywhere, or at a parametric point of the closed cell, often on its boundary.
Vec3d some_point(Shape shape, const Vertices& v, Random& random) {
  if (random.below(3) == 0)
    return point_in_box(shape, v, random);
  Vec3d r = random.uniform({0, 0, 0}, {1, 1, 1});
  if (random.below(2) == 0)
    r[random.below(3)] = random.below(2);
  if (shape == Shape::tetrahedron)
    r = {r.x, (1 - r.x) * r.y, (1 - r.x) * (1 - r.y) * r.z};
  if (shape == Shape::wedge)
    r.y *= 1 - r.x;
  return cells::map_to_physical(shape, v.data(), r);
}

/// Where a certificate is given, the exact preimage's margin is within it.
TEST(Certificate, BoundsTheMarginsError) {
  std::uint64_t seed = 800;
  for (const Kind& kind : kinds) {
    SCOPED_TRACE(std::string(kind.name) + ", seed " + std::to_string(++seed));
    Random random(seed);
    for (Shape shape : all_shapes) {
      int inside = 0, refused = 0;
      double worst = 0.0;
      for (int i = 0; i < 250; ++i) {
        const Vertices v = make_cell(shape, kind, random);
        const Vec3d p = some_point(shape, v, random);
        const auto map = cells::inverse_map(shape, v.data(), p);
        if (cells::contain_exact(shape, v.data(), p).where == cells::Containment::inside) {
          ++inside;
          refused += !(map.margin > map.error);
        }
        if (!(map.error < HUGE_VAL) || (shape == Shape::pyramid && p == v[4]))
          continue; // the apex is answered apart
        ASSERT_TRUE(map.converged);
        const ExactMap exact(shape, v);
        const double off =
            std::fabs(static_cast<double>(exact.margin(exact.solve(map.r, p)) - Real(map.margin)));
        ASSERT_LE(off, map.error) << describe(shape, v.data(), p);
        worst = std::fmax(worst, off / map.error);
      }
      // A third of the points inside were meant for the boundary and are within rounding of it.
      EXPECT_GT(inside, 30) << mesh::shape_name(shape);
      EXPECT_LT(refused, inside * 2 / 3) << mesh::shape_name(shape);
      EXPECT_TRUE(worst > 1e-6 || kind.jitter == 0.0) << worst; // not an idle bound
    }
  }
}

/// What the certificate proves about random points agrees with exact containment, and it is refused
/// to few. Jitter 0.2 folds no cell; 0.4 does, and then a preimage may not mean inside.
TEST(Certificate, ProvesNearlyAllRandomPoints) {
  Random random(850);
  for (Shape shape : all_shapes)
    for (const Kind& kind : {kinds[1], kinds[2], kinds[3]}) {
      int inside = 0, refused = 0, outside = 0, refused_outside = 0;
      for (int i = 0; i < 20000; ++i) {
        const Vertices v = make_cell(shape, kind, random);
        const Vec3d p = point_in_box(shape, v, random);
        const bool in =
            cells::contain_exact(shape, v.data(), p).where == cells::Containment::inside;
        const auto map = cells::inverse_map(shape, v.data(), p);
        (in ? inside : outside) += 1;
        if (in)
          refused += !(map.margin > map.error);
        else
          refused_outside += !(map.margin < -map.error);
        if (kind.jitter < 0.3 && shape != Shape::tetrahedron && map.margin > map.error) {
          ASSERT_TRUE(in) << describe(shape, v.data(), p);
        }
        if (shape == Shape::tetrahedron && std::fabs(map.margin) > map.error) {
          ASSERT_EQ(map.margin > 0, in) << describe(shape, v.data(), p);
        }
      }
      RecordProperty(std::string(mesh::shape_name(shape)) + "_" + kind.name,
                     std::to_string(refused) + " of " + std::to_string(inside) +
                         " inside refused, " + std::to_string(refused_outside) + " of " +
                         std::to_string(outside) + " outside");
      EXPECT_LE(refused, inside / (kind.jitter < 0.3 ? 2000 : 100))
          << mesh::shape_name(shape) << ", " << kind.name;
    }
}

/// A point in the cell comes back to within 8 roundings of the cell's extent in each coordinate
/// (about its first vertex): r's own rounding makes up to three, the residual's the rest;
/// measured 5.
TEST(InverseMap, AnswersMapBackToThePoint) {
  std::uint64_t seed = 870;
  for (const Kind& kind : kinds) {
    SCOPED_TRACE(std::string(kind.name) + ", seed " + std::to_string(++seed));
    Random random(seed);
    for (Shape shape : all_shapes) {
      double worst = 0.0;
      int inside = 0, lost = 0;
      for (int i = 0; i < 300; ++i) {
        const Vertices v = make_cell(shape, kind, random);
        const Vec3d p = some_point(shape, v, random);
        if (!cells::holds(cells::contain_exact(shape, v.data(), p).where))
          continue;
        ++inside;
        const auto map = cells::inverse_map(shape, v.data(), p);
        lost += !map.converged;
        if (!map.converged || (shape == Shape::pyramid && p == v[4]))
          continue;
        const ExactMap exact(shape, v);
        const RealVec f = exact.evaluate(exact.from_vtk(map.r), p)[0];
        for (int a = 0; a < 3; ++a) {
          double extent = 0.0;
          for (int k = 1; k < mesh::vertex_count(shape); ++k)
            extent = std::fmax(extent, std::fabs(v[std::size_t(k)][a] - v[0][a]));
          const double units =
              std::fabs(static_cast<double>(f[std::size_t(a)])) / (extent * 0x1p-53);
          worst = std::fmax(worst, units);
          ASSERT_LE(units, 8) << describe(shape, v.data(), p);
        }
      }
      EXPECT_GT(inside, 40);
      EXPECT_LE(lost, 2) << mesh::shape_name(shape);
      EXPECT_TRUE(worst > 0.01 || kind.jitter == 0.0);
    }
  }
}

TEST(InverseMap, PacksGiveTheBitsOfScalarsOnEveryTarget) {
  Random random(890);
  std::uint64_t done = 0;
  for (Shape shape : all_shapes)
    for (int b = 0; b < 60; ++b) {
      LaneBlock block;
      std::vector<cells::InverseMap<double>> scalars;
      for (int k = 0; k < LaneBlock::size; ++k) {
        Vertices v = make_cell(shape, kinds[random.below(8)], random);
        if (random.below(16) == 0)
          v[1] = v[0];
        if (random.below(64) == 0)
          v[std::size_t(random.below(4))].y = std::nan("");
        const Vec3d p = random.below(16) == 0 ? v[4] : some_point(shape, v, random);
        scalars.push_back(cells::inverse_map(shape, v.data(), p));
        block.add(shape, v.data(), p);
      }
      for (const std::int64_t target : fixtures::simd_targets()) {
        fixtures::use_simd_target(target);
        cells::InverseMap<double> lanes[LaneBlock::size];
        invert_lanes(shape, block, lanes);
        for (std::size_t k = 0; k < LaneBlock::size; ++k, ++done) {
          const auto bits = [](const cells::InverseMap<double>& m) {
            const double all[] = {m.r.x, m.r.y, m.r.z, m.margin, m.error};
            std::array<std::uint64_t, 6> out{};
            std::memcpy(out.data(), all, sizeof all);
            for (std::size_t i = 0; i < 5; ++i)
              if (std::isnan(all[i]))
                out[i] = 1; // which NaN is the compiler's choice
            out[5] = m.converged;
            return out;
          };
          ASSERT_EQ(bits(lanes[k]), bits(scalars[k])) << mesh::shape_name(shape) << ", block " << b
                                                      << ", lane " << k << ", target " << target;
        }
      }
      fixtures::use_simd_target(0);
    }
  EXPECT_GT(done, 10000u);
}

} // namespace
} // namespace insitu::test

/// Cases with a known answer: tables, collapsed and broken cells, the range of doubles, and two
/// tempting tests of containment that are wrong.

#include <gtest/gtest.h>
#include <limits>
#include <map>
#include <set>

#include "cases.h"
#include "cells/exact/contain_exact.h"
#include "oracle.h"

namespace insitu::test {
namespace {

using cells::contain_exact;
using cells::Containment;

Containment where(Shape shape, const Vertices& v, const Vec3d& p) {
  return contain_exact(shape, v.data(), p).where;
}
template <std::size_t N>
Vertices pick(const Vertices& v, const int (&order)[N]) {
  Vertices result{};
  for (std::size_t i = 0; i < N; ++i)
    result[i] = v[order[i]];
  return result;
}
Vertices jittered(Shape shape, double jitter, double snap, Random& random) {
  Vertices v = unit_cell(shape);
  for (Vec3d& p : v) {
    p += random.uniform({-jitter, -jitter, -jitter}, {jitter, jitter, jitter});
    if (snap > 0) {
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = std::round(p[axis] / snap) * snap;
    }
  }
  return v;
}

TEST(FaceTable, ClosedOutwardAndEuler) {
  for (Shape shape : all_shapes) {
    SCOPED_TRACE(mesh::shape_name(shape));
    const cells::FaceTable table = cells::face_table(shape);
    EXPECT_EQ(table.vertex_count, mesh::vertex_count(shape));
    EXPECT_EQ(table.vertex_count - table.edge_count + table.face_count, 2);
    std::set<std::pair<int, int>> directed;
    const Vertices v = unit_cell(shape);
    Vec3d centre{};
    for (int i = 0; i < table.vertex_count; ++i)
      centre += v[i] / double(table.vertex_count);
    for (int f = 0; f < table.face_count; ++f) {
      const cells::Face& face = table.faces[f];
      for (int i = 0; i < face.vertex_count; ++i) {
        const int a = face.vertices[i], b = face.vertices[(i + 1) % face.vertex_count];
        EXPECT_TRUE(directed.insert({a, b}).second);
      }
      const Vec3d a = v[face.vertices[0]], b = v[face.vertices[1]], c = v[face.vertices[2]];
      EXPECT_LT(dot(cross(b - a, c - a), centre - a), 0.0) << "face " << f;
    }
    EXPECT_EQ(int(directed.size()), 2 * table.edge_count);
    for (int e = 0; e < table.edge_count; ++e) {
      const int a = table.edges[e].vertices[0], b = table.edges[e].vertices[1];
      EXPECT_TRUE(directed.count({a, b}) == 1 && directed.count({b, a}) == 1) << "edge " << e;
    }
  }
}

TEST(FaceTable, CanonicalOrderIsTheSameFromBothSides) {
  Random random(401);
  for (int i = 0; i < 2000; ++i) {
    Vertices v{};
    for (int k = 0; k < 4; ++k)
      v[k] = {double(random.below(3)), double(random.below(3)), double(random.below(3))};
    const cells::Face face{4, {0, 1, 2, 3}};
    const cells::Quad reference = cells::canonical_order(face, v.data());
    const auto triangles = [&v](const cells::Quad& q) {
      // As sets of points; those without area do not count.
      std::multiset<std::multiset<std::array<double, 3>>> result;
      for (int second : {1, 2}) {
        const Vec3d a = v[q.vertices[0]], b = v[q.vertices[second]], c = v[q.vertices[second + 1]];
        const Vec3d n = cross(b - a, c - a);
        if (n == Vec3d{})
          continue;
        result.insert({{a.x, a.y, a.z}, {b.x, b.y, b.z}, {c.x, c.y, c.z}});
      }
      return result;
    };
    for (int start = 0; start < 4; ++start) {
      for (int step : {1, 3}) {
        cells::Face other{4, {}};
        for (int k = 0; k < 4; ++k)
          other.vertices[k] = std::uint8_t((start + step * k) & 3);
        ASSERT_EQ(triangles(cells::canonical_order(other, v.data())), triangles(reference)) << i;
      }
    }
  }
}

TEST(ContainExact, NamesTheFeature) {
  const Vertices v = unit_cell(Shape::hexahedron);
  const auto at = [&v](double x, double y, double z) {
    return contain_exact(Shape::hexahedron, v.data(), {x, y, z});
  };
  EXPECT_EQ(at(0.5, 0.5, 0.5).where, Containment::inside);
  EXPECT_EQ(at(0.5, 0.5, 0.5).feature, -1);
  EXPECT_FALSE(at(0.5, 0.5, 0.5).exact_used);
  EXPECT_EQ(at(0, 0.5, 0.5).feature, 0);
  EXPECT_EQ(at(1, 0.5, 0.25).feature, 1);
  EXPECT_EQ(at(0.5, 0.5, 1).feature, 5);
  EXPECT_EQ(at(0.5, 0.5, 1).where, Containment::on_face);
  EXPECT_EQ(at(0.5, 0, 0).where, Containment::on_edge);
  EXPECT_EQ(at(0.5, 0, 0).feature, 0);
  EXPECT_EQ(at(1, 1, 1).where, Containment::on_vertex);
  EXPECT_EQ(at(1, 1, 1).feature, 6);
  EXPECT_EQ(at(1, 1, std::nextafter(1.0, 2.0)).where, Containment::outside);
  EXPECT_EQ(at(0.5, 0.5, std::nextafter(1.0, 0.0)).where, Containment::inside);
  EXPECT_EQ(contain_exact(Shape::none, v.data(), {0.5, 0.5, 0.5}).where, Containment::outside);
}

TEST(ContainExact, IndependentOfNumberingAndOrientation) {
  constexpr std::uint64_t seed = 402;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  // Quarter turn, mirror image (inverted cell), and bottom to top.
  const int turn[] = {1, 2, 3, 0, 5, 6, 7, 4}, mirror[] = {3, 2, 1, 0, 7, 6, 5, 4};
  const int roll[] = {3, 2, 6, 7, 0, 1, 5, 4}, voxel[] = {0, 1, 3, 2, 4, 5, 7, 6};
  for (int i = 0; i < 4000; ++i) {
    const double jitter = random.below(4) == 0 ? 1.0 : 0.25;
    const Vertices v =
        jittered(Shape::hexahedron, jitter, random.below(2) == 0 ? 0.125 : 0, random);
    const Vec3d p = adversarial_point(Shape::hexahedron, v.data(), random, true);
    const Containment expected = where(Shape::hexahedron, v, p);
    for (const Vertices& w : {pick(v, turn), pick(v, mirror), pick(v, roll)}) {
      ASSERT_EQ(where(Shape::hexahedron, w, p), expected)
          << describe(Shape::hexahedron, v.data(), p);
    }
    ASSERT_EQ(where(Shape::voxel, pick(v, voxel), p), expected);
  }
}

/// Hexahedra with coincident vertices are the pyramid, wedge or tetrahedron that is left.
TEST(ContainExact, CollapsedHexahedra) {
  constexpr std::uint64_t seed = 403;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const int pyramid[] = {0, 1, 2, 3, 4, 4, 4, 4}, wedge[] = {0, 1, 2, 2, 3, 4, 5, 5};
  const int tetrahedron[] = {0, 1, 2, 2, 3, 3, 3, 3};
  std::map<Containment, int> seen;
  for (int i = 0; i < 6000; ++i) {
    const double snap = random.below(2) == 0 ? 0x1p-4 : 0.0;
    const auto check = [&](Shape shape, const auto& order) {
      const Vertices v = jittered(shape, 0.2, snap, random);
      const Vec3d p = adversarial_point(shape, v.data(), random, snap > 0);
      const Containment expected = where(shape, v, p);
      ++seen[expected];
      ASSERT_EQ(where(Shape::hexahedron, pick(v, order), p), expected)
          << describe(shape, v.data(), p);
    };
    check(Shape::pyramid, pyramid);
    check(Shape::wedge, wedge);
    check(Shape::tetrahedron, tetrahedron);
    if (HasFatalFailure())
      return;
  }
  for (Containment c : {Containment::outside, Containment::inside, Containment::on_face,
                        Containment::on_edge, Containment::on_vertex}) {
    EXPECT_GT(seen[c], 100);
  }
}

TEST(ContainExact, CellsWithoutVolume) {
  Vertices flat = unit_cell(Shape::hexahedron), point{};
  for (Vec3d& p : flat)
    p.z = 2;
  EXPECT_EQ(where(Shape::hexahedron, flat, {0.25, 0.5, 2}), Containment::on_face);
  EXPECT_EQ(where(Shape::hexahedron, flat, {0, 0.5, 2}), Containment::on_edge);
  EXPECT_EQ(where(Shape::hexahedron, flat, {0.25, 0.5, std::nextafter(2.0, 3.0)}),
            Containment::outside);
  EXPECT_EQ(where(Shape::hexahedron, flat, {1.5, 0.5, 2}), Containment::outside);
  for (Vec3d& p : point)
    p = {1, 2, 3};
  EXPECT_EQ(where(Shape::hexahedron, point, {1, 2, 3}), Containment::on_vertex);
  EXPECT_EQ(where(Shape::hexahedron, point, {1, 2, 3.5}), Containment::outside);
}

/// A planar face that is not convex is what its edges surround, whichever corner comes first.
TEST(ContainExact, DartAndBowTie) {
  const int turn[] = {1, 2, 3, 0, 5, 6, 7, 4};
  Vertices dart = {
      {{0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {0, 4, 0}, {0, 0, 1}, {4, 0, 1}, {1, 1, 1}, {0, 4, 1}}};
  Vertices tie = {
      {{0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {4, 4, 0}, {0, 0, 1}, {4, 0, 1}, {0, 4, 1}, {4, 4, 1}}};
  for (int start = 0; start < 4; ++start) {
    for (double z : {0.0, 0.5, 1.0}) {
      const Containment held = z == 0.5 ? Containment::inside : Containment::on_face;
      EXPECT_EQ(where(Shape::hexahedron, dart, {0.75, 0.75, z}), held);
      EXPECT_EQ(where(Shape::hexahedron, dart, {0.25, 2.5, z}), held);
      EXPECT_EQ(where(Shape::hexahedron, dart, {1.125, 1.125, z}), Containment::outside);
      EXPECT_EQ(where(Shape::hexahedron, dart, {1.5, 1.5, z}), Containment::outside);
      EXPECT_EQ(where(Shape::hexahedron, tie, {2, 0.5, z}), held);
      EXPECT_EQ(where(Shape::hexahedron, tie, {2, 3.5, z}), held);
      EXPECT_EQ(where(Shape::hexahedron, tie, {0.5, 2, z}), Containment::outside);
    }
    dart = pick(dart, turn);
    tie = pick(tie, turn);
  }
}

/// The answer survives any scaling that leaves the coordinates representable.
TEST(ContainExact, WholeRangeOfDoubles) {
  constexpr std::uint64_t seed = 404;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (int i = 0; i < 300; ++i) {
    for (Shape shape : all_shapes) {
      // Multiples of 1/8, at most 10: 7 bits, so 2^-1071 and 2^1020 are in range.
      const Vertices v = jittered(shape, 0.5, 0.125, random);
      Vec3d p = adversarial_point(shape, v.data(), random, true);
      for (int axis = 0; axis < 3; ++axis)
        p[axis] = std::round(p[axis] * 8) / 8;
      const Containment expected = where(shape, v, p);
      for (int trial = 0; trial < 4; ++trial) { // each axis its own
        int k[3];
        for (int& exponent : k)
          exponent = random.below(2092) - 1071;
        if (trial == 0)
          k[0] = random.below(40) - 560, k[1] = random.below(40) - 560;
        if (trial == 1)
          k[1] = random.below(40) - 560, k[2] = random.below(40) - 560;
        const auto stretched = [&k](const Vec3d& a) {
          return Vec3d{std::ldexp(a.x, k[0]), std::ldexp(a.y, k[1]), std::ldexp(a.z, k[2])};
        };
        Vertices scaled{};
        for (int n = 0; n < 8; ++n)
          scaled[n] = stretched(v[n]);
        ASSERT_EQ(where(shape, scaled, stretched(p)), expected)
            << "2^" << k[0] << ", " << k[1] << ", " << k[2] << " " << describe(shape, v.data(), p);
      }
      for (int k : {-1071, -1050, -900, -600, -400, -160, -100, 100, 148, 152, 400, 900, 1020}) {
        Vertices scaled = v;
        for (Vec3d& s : scaled)
          s = {std::ldexp(s.x, k), std::ldexp(s.y, k), std::ldexp(s.z, k)};
        const Vec3d q = {std::ldexp(p.x, k), std::ldexp(p.y, k), std::ldexp(p.z, k)};
        ASSERT_EQ(where(shape, scaled, q), expected)
            << "2^" << k << " " << describe(shape, v.data(), p);
      }
    }
  }
  // Differences that overflow.
  Vertices huge = unit_cell(Shape::hexahedron);
  constexpr double largest = std::numeric_limits<double>::max();
  for (Vec3d& p : huge)
    p = {p.x > 0 ? largest : -largest, p.y > 0 ? largest : -largest, p.z > 0 ? largest : -largest};
  EXPECT_EQ(where(Shape::hexahedron, huge, {1, 2, 3}), Containment::inside);
  EXPECT_EQ(where(Shape::hexahedron, huge, {largest, 2, 3}), Containment::on_face);
  EXPECT_EQ(where(Shape::hexahedron, huge, {largest, 2, -largest}), Containment::on_edge);
}

/// One coordinate off by the least double there is.
TEST(ContainExact, MixedMagnitudes) {
  constexpr double least = std::numeric_limits<double>::denorm_min();
  Vertices v = unit_cell(Shape::hexahedron);
  EXPECT_EQ(where(Shape::hexahedron, v, {0.5, 0.5, least}), Containment::inside);
  EXPECT_EQ(where(Shape::hexahedron, v, {0.5, 0.5, -least}), Containment::outside);
  v[2].z = least; // the bottom is now twisted, if barely: z = least x y
  EXPECT_EQ(where(Shape::hexahedron, v, {0.5, 0.5, least}), Containment::inside);
  EXPECT_EQ(where(Shape::hexahedron, v, {0.5, 0.5, 0}), Containment::outside);
  EXPECT_EQ(where(Shape::hexahedron, v, {0.5, 0, 0}), Containment::on_edge);
  v[2].z = 4 * least;
  EXPECT_EQ(where(Shape::hexahedron, v, {0.5, 0.5, least}), Containment::on_face);
  EXPECT_EQ(where(Shape::hexahedron, v, {0.5, 0.25, least}), Containment::inside);
  EXPECT_EQ(where(Shape::hexahedron, v, {0.5, 0.75, least}), Containment::outside);
}

/// Whatever the rest of the cell looks like: NaN must not slip through a comparison.
TEST(ContainExact, NotFiniteIsOutsideOfRandomCells) {
  constexpr std::uint64_t seed = 406;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  for (int i = 0; i < 20000; ++i) {
    const Shape shape = all_shapes[random.below(5)];
    Vertices v = jittered(shape, 1.0, random.below(2) == 0 ? 0.25 : 0.0, random);
    const Vec3d p = adversarial_point(shape, v.data(), random, true);
    const double bad[] = {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL};
    for (int n = 1 + random.below(3); n > 0; --n) {
      v[random.below(mesh::vertex_count(shape))][random.below(3)] = bad[random.below(3)];
    }
    ASSERT_EQ(where(shape, v, p), Containment::outside) << describe(shape, v.data(), p);
  }
}

TEST(ContainExact, NotFiniteIsOutside) {
  for (Shape shape : all_shapes) {
    for (double bad : {std::numeric_limits<double>::quiet_NaN(), HUGE_VAL, -HUGE_VAL}) {
      const Vertices v = unit_cell(shape);
      const Vec3d p{0.25, 0.25, 0.25};
      ASSERT_EQ(where(shape, v, p), Containment::inside);
      for (int axis = 0; axis < 3; ++axis) {
        Vec3d q = p;
        q[axis] = bad;
        EXPECT_EQ(where(shape, v, q), Containment::outside);
        for (int i = 0; i < mesh::vertex_count(shape); ++i) {
          Vertices w = v;
          w[i][axis] = bad;
          EXPECT_EQ(where(shape, w, p), Containment::outside);
          EXPECT_EQ(where(shape, w, v[i == 0 ? 1 : 0]), Containment::outside);
        }
      }
    }
  }
}

/// a c - b d of a quad's patch, in double, taken for the side of the face everywhere.
double patch_product(const Vec3d& p00, const Vec3d& p10, const Vec3d& p11, const Vec3d& p01,
                     const Vec3d& q) {
  const Vec3d r00 = p00 - q, r10 = p10 - q, r11 = p11 - q, r01 = p01 - q;
  const double a = -dot(r10, cross(r11, r01)), b = dot(r00, cross(r11, r01));
  const double c = -dot(r01, cross(r00, r10)), d = dot(r11, cross(r00, r10));
  return a * c - b * d;
}

/// Trap: "inside when it is on the inner side of all six patches". The quadric of a patch goes on
/// beyond the patch and cuts through the cell.
TEST(Traps, SixSignsJoinedByAnd) {
  constexpr std::uint64_t seed = 405;
  SCOPED_TRACE("seed " + std::to_string(seed));
  Random random(seed);
  const cells::FaceTable table = cells::face_table(Shape::hexahedron);
  int inside = 0, rejected = 0;
  for (int i = 0; i < 200; ++i) {
    const Vertices v = jittered(Shape::hexahedron, 0.25, 0.0, random);
    Vec3d centre{};
    for (const Vec3d& p : v)
      centre += p / 8.0;
    for (int k = 0; k < 50; ++k) {
      const Vec3d p = random.uniform({0, 0, 0}, {1, 1, 1});
      if (where(Shape::hexahedron, v, p) != Containment::inside)
        continue;
      ++inside;
      bool all = true;
      for (int f = 0; f < table.face_count; ++f) {
        const auto& c = table.faces[f].vertices;
        const auto side = [&](const Vec3d& q) {
          return patch_product(v[c[0]], v[c[1]], v[c[2]], v[c[3]], q) > 0;
        };
        all = all && side(p) == side(centre);
      }
      if (all)
        continue;
      ++rejected;
      ASSERT_EQ(oracle_contain(Shape::hexahedron, v.data(), p, random.bits()), Containment::inside)
          << describe(Shape::hexahedron, v.data(), p);
    }
  }
  EXPECT_GT(inside, 5000);
  EXPECT_GT(rejected, inside * 5 / 100);
  RecordProperty("rejected_percent", rejected * 100 / inside);
}

/// Trap: a c - b d of a planar quad has the same sign on both sides of it, or none.
TEST(Traps, ProductOfAPlanarQuad) {
  for (const Vec3d& corner : {Vec3d{1, 1, 1.75}, Vec3d{1.5, 1.25, 2.0625}}) {
    Vertices v = unit_cell(Shape::hexahedron);
    v[4].z = 1, v[5].z = 1.5, v[6] = corner, v[7].z = 1.25; // tilted: z = 1 + x/2 + y/4
    for (const Vec3d& on : {Vec3d{0.5, 0.5, 1.375}, Vec3d{0.75, 0.375, 1.46875}}) {
      const Vec3d step{0, 0, 0.125};
      const double below = patch_product(v[4], v[5], v[6], v[7], on - step);
      const double above = patch_product(v[4], v[5], v[6], v[7], on + step);
      EXPECT_EQ(below > 0, above > 0);
      EXPECT_EQ(below < 0, above < 0);
      EXPECT_EQ(where(Shape::hexahedron, v, on - step), Containment::inside);
      EXPECT_EQ(where(Shape::hexahedron, v, on), Containment::on_face);
      EXPECT_EQ(where(Shape::hexahedron, v, on + step), Containment::outside);
    }
  }
}

} // namespace
} // namespace insitu::test

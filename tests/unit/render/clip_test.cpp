#include <cmath>
#include <gtest/gtest.h>

#include "core/random.h"
#include "unit/render/render_mesh.h"

namespace insitu::test {
namespace {

using render::Clip;
using render::Stretch;

Clip plane(const Vec3d& point, const Vec3d& normal) {
  return {Clip::Kind::plane, point, normal};
}
Clip box(const Vec3d& low, const Vec3d& high, bool inside = true) {
  return {Clip::Kind::box, low, high, 0, inside};
}
Clip sphere(const Vec3d& centre, double radius, bool inside = true) {
  return {Clip::Kind::sphere, centre, {}, radius, inside};
}

std::vector<Stretch> clip(const std::vector<Clip>& clips, const render::Ray& ray, double near = 0,
                          double far = HUGE_VAL) {
  std::vector<Stretch> stays{{7, 8}}; // what was there is forgotten
  render::clip_ray(clips, ray, near, far, stays);
  return stays;
}

void expect_stretches(const std::vector<Stretch>& found,
                      const std::vector<std::pair<double, double>>& expected) {
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < found.size(); ++i) {
    EXPECT_DOUBLE_EQ(found[i].from, expected[i].first);
    EXPECT_DOUBLE_EQ(found[i].to, expected[i].second);
  }
}

/// The oracle: how far p lies on the kept side of a clip, negative where it is cut away.
double kept_by(const Clip& c, const Vec3d& p) {
  double inside = 0;
  switch (c.kind) {
  case Clip::Kind::plane:
    return -dot(p - c.point, c.vector);
  case Clip::Kind::box:
    inside = HUGE_VAL;
    for (int a = 0; a < 3; ++a)
      inside = std::min({inside, p[a] - c.point[a], c.vector[a] - p[a]});
    break;
  case Clip::Kind::sphere:
    inside = c.radius - std::sqrt(dot(p - c.point, p - c.point));
    break;
  }
  return c.keep_inside ? inside : -inside;
}

TEST(Clip, ClosedForms) {
  const render::Ray along_x{{0, 0, 0}, {1, 0, 0}};
  expect_stretches(clip({}, along_x, 1, 2), {{1, 2}});
  expect_stretches(clip({}, along_x, 2, 1), {});
  expect_stretches(clip({plane({3, 9, 9}, {1, 0, 0})}, along_x), {{0, 3}});
  expect_stretches(clip({plane({3, 9, 9}, {-2, 0, 0})}, along_x), {{3, HUGE_VAL}});
  expect_stretches(clip({box({1, -1, -1}, {2, 1, 1})}, along_x), {{1, 2}});
  expect_stretches(clip({box({1, -1, -1}, {2, 1, 1}, false)}, along_x), {{0, 1}, {2, HUGE_VAL}});
  expect_stretches(clip({sphere({5, 3, 0}, 5)}, along_x), {{1, 9}});
  expect_stretches(clip({sphere({5, 3, 0}, 5, false)}, along_x, 2, 8), {});
  // Two holes and a limit on both sides.
  expect_stretches(clip({sphere({5, 0, 0}, 1, false), box({7, -1, -1}, {8, 1, 1}, false),
                         plane({10, 0, 0}, {1, 0, 0}), plane({2, 0, 0}, {-1, 0, 0})},
                        along_x),
                   {{2, 4}, {6, 7}, {8, 10}});
  // The order of the holes does not matter.
  expect_stretches(
      clip({box({7, -1, -1}, {8, 1, 1}, false), sphere({5, 0, 0}, 1, false)}, along_x, 0, 9),
      {{0, 4}, {6, 7}, {8, 9}});
  expect_stretches(clip({box({4, -1, -1}, {5, 1, 1}, false), box({1, -1, -1}, {2, 1, 1}, false),
                         box({6, -1, -1}, {7, 1, 1}, false)},
                        along_x, 0, 9),
                   {{0, 1}, {2, 4}, {5, 6}, {7, 9}});
}

TEST(Clip, DirectionsWithoutAComponent) {
  const render::Ray along_x{{0, 0, 0}, {1, 0, 0}};
  // Parallel to the plane: all or nothing; within it stays.
  expect_stretches(clip({plane({0, 1, 0}, {0, 1, 0})}, along_x, 0, 1), {{0, 1}});
  expect_stretches(clip({plane({0, 0, 0}, {0, 1, 0})}, along_x, 0, 1), {{0, 1}});
  expect_stretches(clip({plane({0, -1, 0}, {0, 1, 0})}, along_x, 0, 1), {});
  // Along a box's face, and beside it.
  expect_stretches(clip({box({1, 0, -1}, {2, 1, 1})}, along_x), {{1, 2}});
  expect_stretches(clip({box({1, 1e-300, -1}, {2, 1, 1})}, along_x), {});
  expect_stretches(clip({box({1, 1e-300, -1}, {2, 1, 1}, false)}, along_x, 0, 9), {{0, 9}});
  expect_stretches(clip({box({-1, -1, -1}, {1, 1, 1})}, {{0, 0, 0}, {-0.0, 0, -1}}), {{0, 1}});
  // A sphere that is just touched.
  expect_stretches(clip({sphere({3, 1, 0}, 1)}, along_x), {});
  expect_stretches(clip({sphere({3, 1, 0}, 1, false)}, along_x, 0, 9), {{0, 3}, {3, 9}});
}

TEST(Clip, TheViewerMayBeInsideOrFarAway) {
  const render::Ray along_z{{0, 0, 0}, {0, 0, 1}};
  expect_stretches(clip({sphere({0, 0, 1}, 4)}, along_z), {{0, 5}});
  expect_stretches(clip({sphere({0, 0, 1}, 4, false)}, along_z), {{5, HUGE_VAL}});
  expect_stretches(clip({sphere({0, 0, -9}, 4)}, along_z), {}); // behind
  expect_stretches(clip({box({-1, -1, -1}, {1, 1, 1}, false)}, along_z), {{1, HUGE_VAL}});
  // 1e6 radii away, at an offset: crossings as good as the coordinates' rounding, 1e-9 here.
  const Vec3d centre{6.4e6, -6.4e6, 6.4e6};
  const render::Ray far{centre - Vec3d{1e6, 0.6, 0}, {1, 0, 0}};
  const auto stays = clip({sphere(centre, 1)}, far);
  ASSERT_EQ(stays.size(), 1u);
  EXPECT_NEAR(stays[0].from, 1e6 - 0.8, 5e-9);
  EXPECT_NEAR(stays[0].to, 1e6 + 0.8, 5e-9);
}

TEST(Clip, AgreesWithSampling) {
  int parted = 0, empty = 0;
  for (std::uint64_t i = 0; i < 4000; ++i) {
    std::uint64_t channel = 0;
    const auto r = [&](double low, double high) {
      const std::uint64_t c = channel++;
      return low + (high - low) * core::random_unit(41, 100 * i + c / 8, c % 8);
    };
    const auto point = [&](double size) {
      return Vec3d{r(-size, size), r(-size, size), r(-size, size)};
    };
    std::vector<Clip> clips;
    const int count = int(r(0, 5));
    for (int k = 0; k < count; ++k) {
      const bool inside = r(0, 1) < 0.4;
      switch (int(r(0, 3))) {
      case 0:
        clips.push_back({Clip::Kind::plane, point(1), point(1)});
        break;
      case 1: {
        const Vec3d a = point(1.5);
        clips.push_back(box(a, a + Vec3d{r(0, 2), r(0, 2), r(0, 2)}, inside));
        break;
      }
      default:
        clips.push_back({Clip::Kind::sphere, point(1), {}, r(0.2, 1.5), inside});
      }
    }
    const Vec3d origin = point(2);
    Vec3d d = point(0.8) - origin;
    if (i % 5 == 0)
      d[int(i / 5 % 3)] = 0;
    if (i % 15 == 0)
      d[int((i / 5 + 1) % 3)] = 0;
    const render::Ray ray{origin, d / std::sqrt(dot(d, d))};
    const double near = r(0, 0.5), far = r(0.5, 6);
    const auto stays = clip(clips, ray, near, far);
    parted += stays.size() > 1;
    empty += stays.empty();
    double last = near;
    for (const Stretch& s : stays) {
      ASSERT_LE(last, s.from) << "case " << i;
      ASSERT_LT(s.from, s.to) << "case " << i;
      last = s.to;
    }
    ASSERT_LE(last, far) << "case " << i;
    for (int k = 0; k < 200; ++k) {
      const double t = near + (far - near) * (k + 0.5) / 200;
      const Vec3d p = ray.origin + t * ray.direction;
      double kept = HUGE_VAL;
      for (const Clip& c : clips)
        kept = std::min(kept, kept_by(c, p));
      // Within rounding of a crossing either answer is right: coordinates below 8, 1e-12 is
      // thousands of roundings.
      if (std::fabs(kept) > 1e-12) {
        ASSERT_EQ(render::stays_at(stays, t), kept > 0) << "case " << i << ", t " << t;
      }
    }
  }
  EXPECT_GT(parted, 80);
  EXPECT_GT(empty, 400);
}

bool stays_here(const std::vector<Clip>& clips, const Vec3d& p) {
  for (const Clip& c : clips) {
    bool in = true;
    if (c.kind == Clip::Kind::plane)
      in = dot(p - c.point, c.vector) <= 0;
    else if (c.kind == Clip::Kind::sphere)
      in = dot(p - c.point, p - c.point) <= c.radius * c.radius;
    else
      for (int a = 0; a < 3; ++a)
        in = in && p[a] >= c.point[a] && p[a] <= c.vector[a];
    if (in != (c.keep_inside || c.kind == Clip::Kind::plane))
      return false;
  }
  return true;
}

/// In every direction the corners reach as far as what is left does, no less, and, of planes and
/// boxes, no more than what sampling can miss.
TEST(Clip, CornersHoldWhatIsLeft) {
  for (std::uint64_t i = 0; i < 60; ++i) {
    const auto r = [&](std::uint64_t k) { return core::random_unit(61, i, k); };
    const Vec3d low{-1, 0, 2}, high{1, 3, 2.5};
    const auto inside = [&](std::uint64_t k) {
      return low + Vec3d{r(k) * 2, r(k + 1) * 3, r(k + 2) * 0.5};
    };
    std::vector<Clip> clips;
    for (std::uint64_t c = 0; c < i % 4; ++c)
      clips.push_back({Clip::Kind::plane,
                       inside(10 * c),
                       {r(10 * c + 3) - 0.5, r(10 * c + 4) - 0.5, r(10 * c + 5) - 0.5}});
    if (i % 3 == 1)
      clips.push_back({Clip::Kind::box, {-0.5, 0.4, 0}, {0.7, 2.4, 5}});
    if (i % 5 == 1)
      clips.push_back({Clip::Kind::box, {-0.1, 1, 2.1}, {0.1, 2, 2.2}, 0, false});
    if (i % 5 == 2)
      clips.push_back({Clip::Kind::sphere, {0, 1.5, 2.2}, {}, 0.8});
    const std::vector<Vec3d> corners = render::clipped_corners(clips, low, high);
    std::vector<Vec3d> left;
    constexpr int n = 40;
    for (int k = 0; k < n * n * n; ++k) {
      const Vec3d p{low.x + 2 * (k % n + 0.5) / n, low.y + 3 * (k / n % n + 0.5) / n,
                    low.z + 0.5 * (k / n / n + 0.5) / n};
      if (stays_here(clips, p))
        left.push_back(p);
    }
    if (left.empty())
      continue;
    ASSERT_FALSE(corners.empty()) << i;
    for (std::uint64_t d = 0; d < 50; ++d) {
      const Vec3d towards{core::random_unit(62, d, 0) - 0.5, core::random_unit(62, d, 1) - 0.5,
                          core::random_unit(62, d, 2) - 0.5};
      double reach = -HUGE_VAL, found = -HUGE_VAL;
      for (const Vec3d& c : corners)
        reach = std::max(reach, dot(c, towards));
      for (const Vec3d& p : left)
        found = std::max(found, dot(p, towards));
      EXPECT_GE(reach, found - 1e-12) << i;
    }
    for (const Vec3d& c : corners) // none is cut away
      for (const Clip& clip : clips)
        EXPECT_TRUE(clip.kind != Clip::Kind::plane || dot(c - clip.point, clip.vector) <= 1e-12)
            << i;
  }
}

TEST(Clip, CornersOfWhatIsCutInClosedForm) {
  const Vec3d low{0, 0, 0}, high{1, 1, 1};
  const auto box_of = [](const std::vector<Vec3d>& points) {
    std::pair<Vec3d, Vec3d> b{points.at(0), points.at(0)};
    for (const Vec3d& p : points)
      for (int a = 0; a < 3; ++a) {
        b.first[a] = std::min(b.first[a], p[a]);
        b.second[a] = std::max(b.second[a], p[a]);
      }
    return b;
  };
  // A corner of the cube: x + y + z <= 1/2.
  const auto corner =
      render::clipped_corners({{Clip::Kind::plane, {0.5, 0, 0}, {1, 1, 1}}}, low, high);
  EXPECT_EQ(box_of(corner).second, (Vec3d{0.5, 0.5, 0.5}));
  for (const Vec3d& p : corner)
    EXPECT_LE(p.x + p.y + p.z, 0.5 + 1e-15);
  // A second plane through the lid of the first: z = 1/4 leaves corners of both.
  const auto two = render::clipped_corners(
      {{Clip::Kind::plane, {0.5, 0, 0}, {1, 1, 1}}, {Clip::Kind::plane, {0, 0, 0.25}, {0, 0, -1}}},
      low, high);
  EXPECT_EQ(box_of(two).first, (Vec3d{0, 0, 0.25}));
  EXPECT_EQ(box_of(two).second, (Vec3d{0.25, 0.25, 0.5}));
  EXPECT_TRUE(
      render::clipped_corners({{Clip::Kind::plane, {-1, 0, 0}, {1, 0, 0}}}, low, high).empty());
  EXPECT_TRUE(
      render::clipped_corners({{Clip::Kind::box, {2, 2, 2}, {3, 3, 3}}}, low, high).empty());
  // Through its corners and edges, and a box without thickness.
  EXPECT_EQ(box_of(render::clipped_corners({{Clip::Kind::plane, {0, 0, 0}, {1, -1, 0}}}, low, high))
                .second,
            high);
  EXPECT_EQ(
      box_of(render::clipped_corners({{Clip::Kind::plane, {0.5, 0, 0}, {1, 0, 0}}}, low, {1, 1, 0}))
          .second,
      (Vec3d{0.5, 1, 0}));
}

TEST(Clip, SurfacesThatAreCutAwayLetTheRayGoOn) {
  RenderMesh mesh(5, Shape::hexahedron, 0.2);
  const auto x = mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
  render::FrameSettings s;
  s.width = s.height = 1;
  s.camera.position = {-1, 0.45, 0.55};
  s.camera.look_at = {0, 0.45, 0.55};
  s.camera.up = {0, 0, 1};
  s.background = {0, 0, 0};
  s.lighting.enabled = false;
  s.isosurfaces.push_back({x, {0.3}, 1, render::Color{1, 0, 0}});
  s.isosurfaces.push_back({x, {0.7}, 1, render::Color{0, 1, 0}});
  const auto color = [&](const std::vector<Clip>& clips) {
    s.clips = clips;
    const core::Image image = mesh.draw(s);
    const float* p = image.pixel(0, 0);
    return Vec3d{p[0], p[1], p[2]};
  };
  const Vec3d red{1, 0, 0}, green{0, 1, 0}, black{0, 0, 0};
  EXPECT_EQ(color({}), red);
  EXPECT_EQ(color({plane({0.5, 0, 0}, {-1, 0, 0})}), green);
  EXPECT_EQ(color({plane({0.25, 0, 0}, {-1, 0, 0})}), red);
  EXPECT_EQ(color({plane({0.5, 0, 0}, {1, 0, 0})}), red);
  EXPECT_EQ(color({plane({0.25, 0, 0}, {1, 0, 0})}), black);
  EXPECT_EQ(color({sphere({0.3, 0.45, 0.55}, 0.2, false)}), green);
  EXPECT_EQ(color({sphere({0.3, 0.45, 0.55}, 0.2)}), red);
  EXPECT_EQ(color({sphere({0.3, 0.45, 0.55}, 0.2, false), box({-9, -9, -9}, {0.5, 9, 9})}), black);
  s.isosurfaces[0].opacity = 0.5;
  EXPECT_EQ(color({}), (Vec3d{0.5, 0.5, 0}));
  EXPECT_EQ(color({box({0.29, 0, 0}, {0.31, 1, 1}, false)}), green);
  EXPECT_EQ(color({plane({0, 0.45 - 1e-9, 0}, {0, 1, 0})}), black);
  EXPECT_EQ(color({plane({0, 0.45 + 1e-9, 0}, {0, 1, 0})}), (Vec3d{0.5, 0.5, 0}));
}

} // namespace
} // namespace insitu::test

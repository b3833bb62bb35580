// Isosurfaces of whole meshes where numbers are hard: far away, stretched, of values that are no
// numbers, seen from where it is degenerate.
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <optional>

#include "unit/render/placed_mesh.h"

namespace insitu::test {
namespace {

using render::FrameSettings;
using render::IsosurfaceSettings;
using render::IsosurfaceTracer;
using render::Ray;
using render::SurfaceHit;

Vec3d along_axes(const Vec3d& a, const Vec3d& b) {
  return {a.x * b.x, a.y * b.y, a.z * b.z};
}

/// Hits of rays on one surface.
class Traced {
public:
  Traced(RenderMesh& mesh, const render::ScalarField& field, double value)
      : settings_{{field, {value}}}, structures_(mesh.committed.memory) {
    structures_.begin(mesh.sampler(), 0, 0, mesh.committed.threads);
    tracer_.emplace(mesh.sampler(), settings_, structures_);
  }
  const std::vector<SurfaceHit>& operator()(const Ray& ray) {
    tracer_->trace(ray, hits_, counts_);
    return hits_;
  }

private:
  std::vector<IsosurfaceSettings> settings_;
  render::Structures structures_;
  std::optional<IsosurfaceTracer> tracer_;
  std::vector<SurfaceHit> hits_;
  render::SurfaceCounts counts_;
};

/// visit(way): ways from `eye` to places in the unit box.
template <class Visit>
void over_rays(const Vec3d& eye, Visit&& visit) {
  constexpr int n = 12;
  for (int i = 0; i < n * n; ++i) {
    const double u = (i % n + 0.37) / n, v = (i / n + 0.61) / n;
    visit(Vec3d{u, v, 0.5 + 0.3 * std::sin(5 * u + 3 * v)} - eye);
  }
}

double plane(const Vec3d& p) {
  return p.x + 2 * p.y + 3 * p.z;
}
constexpr double middle = 2.9; // of the plane

bool in_box(const Vec3d& p, double margin) {
  return std::min({p.x, p.y, p.z}) > -margin && std::max({p.x, p.y, p.z}) < 1 + margin;
}

/// Traces the plane in a box that is stretched and moved: where it is in the unit box.
void expect_plane(RenderMesh& mesh, const render::ScalarField& field, double value,
                  const Vec3d& scale, const Vec3d& offset, const Vec3d& eye, double tolerance) {
  Traced trace(mesh, field, value);
  int found = 0;
  over_rays(eye, [&](const Vec3d& way) {
    const double part = (middle - plane(eye)) / plane(way); // of the way
    const Vec3d hit = eye + part * way;
    if (in_box(hit, 1e-6) != in_box(hit, -1e-6))
      return; // on the rim
    const Vec3d stretched = along_axes(scale, way);
    const double length = std::sqrt(dot(stretched, stretched));
    const std::vector<SurfaceHit>& hits =
        trace({offset + along_axes(scale, eye), stretched / length});
    const bool expected = part > 0 && in_box(hit, 0);
    EXPECT_EQ(hits.size(), std::size_t(expected)) << hit.x << " " << hit.y << " " << hit.z;
    if (expected && hits.size() == 1) {
      EXPECT_NEAR(hits[0].t / length, part, tolerance * std::max(1.0, part));
      ++found;
    }
  });
  EXPECT_GT(found, 20);
}

constexpr Shape all_shapes[] = {Shape::hexahedron, Shape::tetrahedron, Shape::wedge,
                                Shape::pyramid};

TEST(IsosurfaceHard, MeshesFarAwayAndStretched) {
  struct Place {
    Vec3d scale, offset;
    double tolerance;
  };
  // 1e7 rounds vertices by 1e-9; of a stretched box the thin side is a part of the whole.
  for (const Place& at : {Place{{1, 1, 1}, {1e7, -1e7, 1e7}, 1e-7},
                          {{1, 1, 1e-5}, {0, 0, 0}, 1e-9},
                          {{1e5, 1, 1}, {0, 0, 0}, 1e-9},
                          {{1e5, 1e5, 1}, {1e6, 1e6, -10}, 1e-8}})
    for (const Shape shape : all_shapes) {
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", scale " << at.scale.x << " "
                                      << at.scale.y << " " << at.scale.z);
      RenderMesh mesh(placed(5, shape, at.scale, at.offset));
      const auto field = mesh.field("f", INSITU_VERTEX, [&](const Vec3d& p) {
        const Vec3d d = p - at.offset;
        return plane({d.x / at.scale.x, d.y / at.scale.y, d.z / at.scale.z});
      });
      expect_plane(mesh, field, middle, at.scale, at.offset, {1.6, 1.3, 2.2}, at.tolerance);
    }
}

TEST(IsosurfaceHard, FromAFaceAVertexAndFarAway) {
  constexpr double third = 1.0 / 3;
  for (const Shape shape : all_shapes) {
    RenderMesh mesh(3, shape, 0.0); // faces of cells at thirds
    const auto field = mesh.field("f", INSITU_VERTEX, plane);
    for (const Vec3d& eye : {Vec3d{0.5, 0.4, 1.0},
                             {third, 0.4, 0.9},
                             {third, third, 2 * third},
                             {1, 1, 1},
                             {0.9e6, 0.8e6, 1e6}}) {
      SCOPED_TRACE(testing::Message()
                   << "shape " << int(shape) << ", eye " << eye.x << " " << eye.y << " " << eye.z);
      // From 1e6 box lengths, places on the ray are rounded by 1e-10.
      expect_plane(mesh, field, middle, {1, 1, 1}, {}, eye, 1e-9);
    }
  }
}

TEST(IsosurfaceHard, TinyHugeAndAbsentValues) {
  for (const Shape shape : all_shapes) {
    RenderMesh mesh(5, shape, 0.2);
    for (const double scale : {1e-300, 1e-30, 1e30, 1e300}) {
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", values of " << scale);
      const auto field =
          mesh.field("f", INSITU_VERTEX, [&](const Vec3d& p) { return scale * plane(p); });
      expect_plane(mesh, field, scale * middle, {1, 1, 1}, {}, {1.6, 1.3, 2.2}, 1e-9);
    }
    // No surface where values are no numbers, and none at their border.
    const auto holed = mesh.field("h", INSITU_VERTEX, [](const Vec3d& p) {
      return p.x > 0.55 ? std::numeric_limits<double>::quiet_NaN() : p.x;
    });
    for (const auto& [value, expected] : {std::pair(0.15, 1), {0.9, 0}}) {
      Traced trace(mesh, holed, value);
      for (const double y : {0.11, 0.47, 0.83}) {
        const std::vector<SurfaceHit>& hits = trace({{-1, y, 0.4}, {1, 0, 0}});
        ASSERT_EQ(hits.size(), std::size_t(expected)) << value << " at " << y;
        if (expected) {
          EXPECT_NEAR(hits[0].t, 1 + value, 1e-12);
        }
      }
    }
  }
}

TEST(IsosurfaceHard, RaysAlongTheSurfaceAndConstantValues) {
  for (const Shape shape : all_shapes) {
    SCOPED_TRACE(testing::Message() << "shape " << int(shape));
    RenderMesh mesh(4, shape, 0.0);
    const auto x = mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
    Traced on_faces(mesh, x, 0.5), within(mesh, x, 0.6);
    for (const double z : {0.3, 0.5}) { // 0.5: along edges of cells as well
      for (Traced* trace : {&on_faces, &within}) {
        const double value = trace == &on_faces ? 0.5 : 0.6;
        for (const double beside : {-1e-6, 1e-6})
          EXPECT_TRUE((*trace)({{value + beside, -1, z}, {0, 1, 0}}).empty());
        for (const SurfaceHit& hit : (*trace)({{value, -1, z}, {0, 1, 0}})) {
          EXPECT_GE(hit.t, 1 - 1e-12);
          EXPECT_LE(hit.t, 2 + 1e-12);
        }
        // Across, one each, though two cells share the face.
        EXPECT_EQ((*trace)({{-1, 0.37, z}, {1, 0, 0}}).size(), 1u);
      }
    }
    const auto flat = mesh.field("flat", INSITU_VERTEX, [](const Vec3d&) { return 0.45; });
    Traced equal(mesh, flat, 0.45), other(mesh, flat, 0.4501);
    over_rays({1.6, 1.3, 2.2}, [&](const Vec3d& way) {
      const Ray ray{{1.6, 1.3, 2.2}, way / std::sqrt(dot(way, way))};
      EXPECT_TRUE(other(ray).empty());
      const auto [near, far] = box_stretch(ray);
      for (const SurfaceHit& hit : equal(ray)) {
        EXPECT_GE(hit.t, near - 1e-9);
        EXPECT_LE(hit.t, far + 1e-9);
      }
    });
  }
}

TEST(IsosurfaceHard, CellsWithoutThicknessAndSurfacesThatDoNotShow) {
  // Two layers that lie on one another, with one of no thickness between.
  TestMesh cells = box_cells(3, Shape::hexahedron, 0.0);
  const double heights[] = {0.0, 0.5, 0.5, 1.0};
  for (Vec3d& p : cells.vertices)
    p.z = heights[int(std::lround(3 * p.z))];
  RenderMesh mesh(cells);
  const auto field = mesh.field("f", INSITU_VERTEX, plane);
  expect_plane(mesh, field, middle, {1, 1, 1}, {}, {1.6, 1.3, 2.2}, 1e-9);

  FrameSettings s = box_frame(24);
  s.isosurfaces.push_back({field, {2.0}, 0.5});
  const core::Image one = mesh.draw(s);
  s.isosurfaces.push_back({field, {4.0}, 0.0});
  EXPECT_EQ(mesh.draw(s).rgba, one.rgba) << "an opacity of 0";
  s.isosurfaces[1].opacity = 0.5;
  EXPECT_NE(mesh.draw(s).rgba, one.rgba);
}

/// A surface separates values at or above the level from values below: at the field's least value,
/// which it has on a face of the boundary, there is none, and at its greatest all of the face is
/// one.
TEST(IsosurfaceHard, AtTheBoundarysValueIsAllOrNone) {
  for (const Shape shape : {Shape::hexahedron, Shape::wedge, Shape::tetrahedron, Shape::pyramid}) {
    for (const render::RootSearch how :
         {render::RootSearch::exact, render::RootSearch::cubic, render::RootSearch::neubauer}) {
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << " search " << int(how));
      // A quarter of a shell: curved faces, whose crossings' weights do not sum to 1 exactly.
      TestMesh shell = box_cells(2, shape, 0.0);
      std::vector<double> radius;
      for (Vec3d& v : shell.vertices) {
        const double r = 2.0 + v.x, angle = 1.4 * v.y - 0.6;
        radius.push_back(v.x == 0 || v.x == 1 ? 2.0 + v.x : r);
        v = {r * std::cos(angle), r * std::sin(angle), v.z};
      }
      RenderMesh mesh(shell);
      std::size_t next = 0;
      const render::ScalarField field =
          mesh.field("r", INSITU_VERTEX, [&](const Vec3d&) { return radius[next++]; });
      const auto seen = [&](double value) {
        const query::Sampler sampler = mesh.sampler();
        render::Structures structures(mesh.committed.memory);
        structures.begin(sampler, 0, 0, mesh.committed.threads);
        std::vector<IsosurfaceSettings> settings{{field, {value}}};
        settings[0].search = how;
        const IsosurfaceTracer tracer(sampler, settings, structures);
        std::vector<SurfaceHit> hits;
        render::SurfaceCounts counts;
        int found = 0;
        for (int i = 0; i < 40 * 40; ++i) {
          const Vec3d from{20.0, -0.5 + (i % 40 + 0.37) / 40, (i / 40 + 0.43) / 40};
          tracer.trace({from, {-1, 0, 0}}, hits, counts);
          found += !hits.empty();
        }
        return found;
      };
      EXPECT_EQ(seen(2.0), 0);
      EXPECT_EQ(seen(3.0), 40 * 40);
      EXPECT_EQ(seen(2.5), 40 * 40);
      EXPECT_EQ(seen(std::nextafter(2.0, 3.0)), 40 * 40);
    }
  }
}

} // namespace
} // namespace insitu::test

// Transmittance by path tracing against Beer and Lambert's law, through meshes and along rays that
// are hard, on every shape and on blocks.
#include <cmath>
#include <gtest/gtest.h>
#include <tuple>

#include "unit/render/block_mesh.h"
#include "unit/render/path_mesh.h"
#include "unit/render/placed_mesh.h"

namespace insitu::test {
namespace {

using render::FrameSettings;
using render::ScalarField;

constexpr Shape all_shapes[] = {Shape::hexahedron, Shape::tetrahedron, Shape::wedge,
                                Shape::pyramid};

struct Place {
  Vec3d scale{1, 1, 1}, offset{};
  Vec3d operator()(const Vec3d& p) const {
    return {offset.x + scale.x * p.x, offset.y + scale.y * p.y, offset.z + scale.z * p.z};
  }
};

/// A ray in the unit box's coordinates, and the stretch of it from 0 to 1.
struct Way {
  const char* name;
  Vec3d from, to, enter, leave;
};
const Way ways[] = {
    {"through", {-1, 0.45, 0.55}, {2, 0.45, 0.55}, {0, 0.45, 0.55}, {1, 0.45, 0.55}},
    {"slanting", {-1, -0.6, -0.2}, {1, 0.8, 0.6}, {0, 0.1, 0.2}, {1, 0.8, 0.6}},
    {"along faces", {-1, 0.5, 0.3}, {2, 0.5, 0.3}, {0, 0.5, 0.3}, {1, 0.5, 0.3}},
    {"along edges", {-1, 0.5, 0.25}, {2, 0.5, 0.25}, {0, 0.5, 0.25}, {1, 0.5, 0.25}},
    {"along the boundary", {-1, 1, 0.3}, {2, 1, 0.3}, {0, 1, 0.3}, {1, 1, 0.3}},
    {"along the diagonal", {-1, -1, -1}, {2, 2, 2}, {0, 0, 0}, {1, 1, 1}},
    {"from a face inside", {0.5, 0.4, 0.3}, {1, 0.4, 0.3}, {0.5, 0.4, 0.3}, {1, 0.4, 0.3}},
};

double length(const Vec3d& d) {
  return std::sqrt(dot(d, d));
}

/// 16 x 16 paths along one way, without scattering. The unit distance is the stretch inside.
FrameSettings along(const Way& way, const Place& place, const ScalarField& field,
                    const render::TransferFunction& function) {
  FrameSettings s = one_ray();
  s.camera.position = place(way.from);
  s.camera.look_at = place(way.to);
  const Vec3d d = s.camera.look_at - s.camera.position;
  s.camera.up = std::fabs(d.z) < 0.9 * length(d) ? Vec3d{0, 0, 1} : Vec3d{0, 1, 0};
  s.camera.orthographic_height = 1e-300; // all pixels on the very ray
  s.volume = render::VolumeSettings{field, function};
  s.volume->unit_distance = length(place(way.leave) - place(way.enter));
  s.path_tracing->scattering = render::Scattering::none;
  s.path_tracing->samples = 100;
  return s;
}

Estimate alpha_of(const fixtures::Committed& mesh, const FrameSettings& s, core::Memory& memory) {
  render::FrameStatistics statistics;
  const render::FrameImages images =
      render::render_frame(mesh.sampler(), s, mesh.threads, memory, &statistics);
  EXPECT_EQ(statistics.paths.violations, 0);
  return estimate(images.color, 3);
}

TEST(PathHard, StretchedAndFarMeshesOnEveryShape) {
  for (const Place& place : {Place{},
                             {{1e5, 1, 1}, {}},
                             {{1, 1e5, 1e5}, {}},
                             {{1, 1, 1e-5}, {}},
                             {{1e5, 1, 1}, {6.4e6, 6.4e6, 0}}})
    for (const Shape shape : all_shapes) {
      PlacedMesh mesh(placed(4, shape, place.scale, place.offset, 0.0));
      const ScalarField one = mesh.field(std::vector<double>(mesh.cells.vertices.size(), 1.0));
      for (const Way& way : ways) {
        SCOPED_TRACE(testing::Message()
                     << way.name << ", shape " << int(shape) << ", scale " << place.scale.x << " "
                     << place.scale.y << " " << place.scale.z);
        const Estimate found =
            alpha_of(mesh.committed, along(way, place, one, medium_of({1, 1, 1}, 0.6, 0.6)),
                     mesh.committed.memory);
        // Far away the ray along the boundary may lie beyond it by a rounding.
        if (std::string(way.name) == "along the boundary" && place.offset.x != 0) {
          EXPECT_LE(found.mean, 0.6 + most_errors * found.error);
        } else {
          expect_mean(found, 0.6, "alpha");
        }
      }
    }
}

/// Opacity 0 below a value and 0.7 above: a step that lies in cells, on vertices, and at the value
/// of a constant field.
TEST(PathHard, StepsOfOpacityOnEveryShape) {
  const auto step_at = [](double v) {
    return render::TransferFunction(render::ColorMap::built_in("viridis"), 0, 1,
                                    {{0, 0}, {v, 0}, {v, 0.7}, {1, 0.7}});
  };
  const Way& through = ways[0];
  for (const Shape shape : all_shapes) {
    SCOPED_TRACE(testing::Message() << "shape " << int(shape));
    RenderMesh mesh(4, shape, 0.2);
    const auto x = mesh.field("x", INSITU_VERTEX, [](const Vec3d& p) { return p.x; });
    for (const double v : {0.25, 0.5, 0.61}) {
      const Estimate found =
          alpha_of(mesh.committed, along(through, {}, x, step_at(v)), mesh.committed.memory);
      expect_mean(found, 1 - std::pow(0.3, 1 - v), "a step of opacity");
    }
    const auto flat = mesh.field("flat", INSITU_VERTEX, [](const Vec3d&) { return 0.5; });
    // At the very value, interpolation's rounding says which side a sample is on.
    for (const auto& [v, least, most] :
         {std::tuple{0.5 - 1e-14, 0.7, 0.7}, {0.5 + 1e-14, 0.0, 0.0}, {0.5, 0.0, 0.7}}) {
      const Estimate found =
          alpha_of(mesh.committed, along(through, {}, flat, step_at(v)), mesh.committed.memory);
      EXPECT_GE(found.mean, least - most_errors * found.error - 1e-6) << v - 0.5;
      EXPECT_LE(found.mean, most + most_errors * found.error + 1e-6) << v - 0.5;
    }
    // A step from cell to cell.
    RenderMesh even(4, shape, 0.0);
    const auto c =
        even.field("c", INSITU_CELL, [](const Vec3d& p) { return p.x > 0.5 ? 0.9 : 0.1; });
    expect_mean(
        alpha_of(even.committed, along(through, {}, c, step_at(0.5)), even.committed.memory),
        1 - std::sqrt(0.3), "a step of a cell field");
  }
}

TEST(PathHard, TinyHugeAndAbsentValuesOnEveryShape) {
  const double ramp = -std::expm1(-(0.3 * std::log(0.3) + 0.7) / 0.7); // from 0 to 0.7
  for (const Shape shape : all_shapes) {
    SCOPED_TRACE(testing::Message() << "shape " << int(shape));
    RenderMesh mesh(4, shape, 0.2);
    for (const double scale : {1e-300, 1.0, 1e300}) {
      const auto f = mesh.field("f", INSITU_VERTEX, [&](const Vec3d& p) { return scale * p.x; });
      const render::TransferFunction function(render::ColorMap::built_in("viridis"), 0, scale,
                                              {{0.0, 0.0}, {scale, 0.7}});
      expect_mean(alpha_of(mesh.committed, along(ways[0], {}, f, function), mesh.committed.memory),
                  ramp, "a ramp");
    }
    const auto none = mesh.field("n", INSITU_VERTEX, [](const Vec3d&) { return std::nan(""); });
    EXPECT_EQ(alpha_of(mesh.committed, along(ways[0], {}, none, medium_of({1, 1, 1}, 0.6, 0.6)),
                       mesh.committed.memory)
                  .mean,
              0);
  }
}

/// Blocks of all kinds, whose cells are implicit.
TEST(PathHard, StructuredBlocks) {
  for (const insitu_block_kind kind : block_kinds) {
    SCOPED_TRACE(testing::Message() << "kind " << int(kind));
    BlockMesh mesh(kind, 5, [](const Vec3d& p) { return p.x; });
    const auto alpha = [&](const Way& way, const render::TransferFunction& function) {
      return alpha_of(mesh.committed, along(way, {}, mesh.field, function), mesh.committed.memory);
    };
    for (const Way& way : ways)
      expect_mean(alpha(way, medium_of({1, 1, 1}, 0.6, 0.6)), 0.6, way.name);
    const render::TransferFunction step(render::ColorMap::built_in("viridis"), 0, 1,
                                        {{0, 0}, {0.61, 0}, {0.61, 0.7}, {1, 0.7}});
    expect_mean(alpha(ways[0], step), 1 - std::pow(0.3, 0.39), "a step of opacity");
  }
}

} // namespace
} // namespace insitu::test

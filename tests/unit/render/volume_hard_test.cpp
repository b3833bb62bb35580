#include <cmath>
#include <gtest/gtest.h>

#include "render/structures/structures.h"
#include "unit/render/placed_mesh.h"

/// Rays and meshes that break marchers, against Beer and Lambert's law.
namespace insitu::test {
namespace {

using render::OpacityPoint;
using render::TransferFunction;
using render::VolumeSettings;

struct Placing {
  const char* name;
  int n;
  Vec3d scale, offset;
};

class Marched {
public:
  explicit Marched(const Placing& of, Shape shape = Shape::hexahedron, double jitter = 0.0)
      : placing(of), mesh(placed(of.n, shape, of.scale, of.offset, jitter)),
        structures(mesh.committed.memory) {}

  void set(const std::function<double(std::size_t)>& value) {
    std::vector<double> values;
    for (std::size_t v = 0; v < mesh.cells.vertices.size(); ++v)
      values.push_back(value(v));
    field = mesh.field(values);
    structures.begin(mesh.committed.sampler(), 1, ++version, mesh.committed.threads);
  }
  /// In all cells.
  void set_cells(double value) {
    field = mesh.field(std::vector<double>(mesh.cells.cells.size(), value), INSITU_CELL);
    structures.begin(mesh.committed.sampler(), 1, ++version, mesh.committed.threads);
  }
  /// From a point towards another, in the unit box's coordinates. kind: 0 plain, 1 pre-integrated,
  /// 2 with a tolerance.
  render::RayState operator()(VolumeSettings s, const Vec3d& from, const Vec3d& to, int kind) {
    s.preintegrated = kind == 1;
    if (kind == 2)
      s.tolerance = 0.01;
    const query::Sampler sampler = mesh.committed.sampler();
    const render::VolumeMarcher marcher(sampler, s,
                                        volume_structures(sampler, s, 1 << 20, structures));
    render::RayState ray;
    const Vec3d d = at(to) - at(from);
    ray.ray = {at(from), d / std::sqrt(dot(d, d))};
    marcher.start(ray);
    marcher.march({&ray, 1});
    return ray;
  }
  Vec3d at(const Vec3d& p) const {
    Vec3d q;
    for (int a = 0; a < 3; ++a)
      q[a] = placing.offset[a] + placing.scale[a] * p[a];
    return q;
  }
  double length(const Vec3d& from, const Vec3d& to) const {
    const Vec3d d = at(to) - at(from);
    return std::sqrt(dot(d, d));
  }

  Placing placing;
  PlacedMesh mesh;
  render::Structures structures;
  render::ScalarField field;
  std::uint64_t version = 0;
};

constexpr Shape all_shapes[] = {Shape::hexahedron, Shape::tetrahedron, Shape::wedge,
                                Shape::pyramid};

const Placing placings[] = {{"unit", 4, {1, 1, 1}, {0, 0, 0}},
                            {"far away", 4, {1, 1, 1}, {6.4e6, -6.4e6, 6.4e6}},
                            {"aspect 1e5", 4, {1e5, 1, 1}, {0, 0, 0}},
                            {"aspect 1e5 far away", 4, {1e5, 1, 1}, {6.4e6, 6.4e6, 0}},
                            {"one cell", 1, {2, 3, 4}, {-1, 0, 0}}};

/// Rays with the stretch of them that lies in the box.
struct RayCase {
  const char* name;
  Vec3d from, to; ///< origin, and a point it goes towards
  Vec3d enter, leave;
};
const RayCase rays[] = {
    {"through", {-1, 0.4, 0.3}, {0.5, 0.4, 0.3}, {0, 0.4, 0.3}, {1, 0.4, 0.3}},
    {"across", {0.4, 0.3, 3}, {0.4, 0.3, 2}, {0.4, 0.3, 1}, {0.4, 0.3, 0}},
    {"from inside", {0.5, 0.4, 0.3}, {1, 0.4, 0.3}, {0.5, 0.4, 0.3}, {1, 0.4, 0.3}},
    {"from a face", {0, 0.4, 0.3}, {1, 0.4, 0.3}, {0, 0.4, 0.3}, {1, 0.4, 0.3}},
    {"from the far face", {1, 0.4, 0.3}, {2, 0.4, 0.3}, {1, 0.4, 0.3}, {1, 0.4, 0.3}},
    {"along a face", {-1, 0.5, 0.3}, {2, 0.5, 0.3}, {0, 0.5, 0.3}, {1, 0.5, 0.3}},
    {"along an edge", {-1, 0.5, 0.25}, {2, 0.5, 0.25}, {0, 0.5, 0.25}, {1, 0.5, 0.25}},
    {"along the diagonal", {-1, -1, -1}, {2, 2, 2}, {0, 0, 0}, {1, 1, 1}},
    {"beside it", {-1, 1.5, 0.3}, {2, 1.5, 0.3}, {0, 0, 0}, {0, 0, 0}},
    {"from 1e6 radii", {0.4, 0.3, -1e6}, {0.4, 0.3, 0}, {0.4, 0.3, 0}, {0.4, 0.3, 1}},
};

void expect_rays_right(Marched& marched) {
  const Placing& placing = marched.placing;
  for (const RayCase& ray : rays)
    for (const int kind : {0, 1, 2}) {
      // A length that leaves a good part of the light.
      const double length = marched.length(ray.enter, ray.leave);
      VolumeSettings s{marched.field, constant_function(0.6, 0.5)};
      s.unit_distance = length > 0 ? length : 1;
      s.step_factor = 0.3;
      const double expected = length > 0 ? 0.6 : 0.0;
      // Boxes' float rounding, relative; far away, that of the mesh's own coordinates; a ray of
      // 1e6 radii is known to 1e-10 of them.
      double slack = 2e-6;
      if (length > 0)
        slack += 4e-9 * std::fabs(placing.offset.x) / length;
      const render::RayState found = marched(s, ray.from, ray.to, kind);
      EXPECT_NEAR(found.alpha, expected, slack) << placing.name << ", " << ray.name << ", " << kind;
      EXPECT_NEAR(found.color.g, 0.5 * expected, slack)
          << placing.name << ", " << ray.name << ", " << kind;
    }
}

/// By a field of vertices and one of cells, of straight cells, along whose faces and edges some of
/// the rays go, and of crooked ones.
TEST(VolumeHard, RaysAndMeshes) {
  for (const Placing& placing : placings)
    for (const Shape shape : all_shapes)
      for (const double jitter : {0.0, 0.2}) {
        SCOPED_TRACE(testing::Message() << mesh::shape_name(shape) << ", jitter " << jitter);
        Marched marched(placing, shape, jitter);
        marched.set([](std::size_t) { return 0.5; });
        expect_rays_right(marched);
        marched.set_cells(0.5);
        expect_rays_right(marched);
      }
}

/// A field from 0 to `size` along the ray, with everything relative to it: the image is that of the
/// field from 0 to 1.
TEST(VolumeHard, TinyAndHugeValues) {
  for (const Shape shape : all_shapes) {
    float truth[3] = {0, 0, 0};
    for (const double size : {1.0, 1e-300, 1e300}) {
      Marched marched(placings[0], shape);
      marched.set([&](std::size_t v) { return size * marched.mesh.cells.vertices[v].x; });
      for (const int kind : {0, 1, 2}) {
        VolumeSettings s{marched.field,
                         {render::ColorMap::built_in("viridis"),
                          0,
                          size,
                          {{0, 0}, {0.3 * size, 0}, {0.3 * size, 0.5}, {size, 0.1}}}};
        s.unit_distance = 0.3;
        s.step = 0.02;
        const render::RayState ray = marched(s, {-1, 0.4, 0.3}, {2, 0.4, 0.3}, kind);
        if (size == 1.0) {
          truth[kind] = ray.alpha;
          EXPECT_GT(ray.alpha, 0.3);
          EXPECT_LT(ray.alpha, 0.9);
        }
        EXPECT_NEAR(ray.alpha, truth[kind], 1e-5) << size << " " << kind;
      }
    }
    EXPECT_NEAR(truth[0], truth[1], 0.02);
    EXPECT_NEAR(truth[0], truth[2], 0.02);
  }
}

void expect_extremes_right(Marched& marched) {
  const auto look = [&](TransferFunction function, int kind) {
    VolumeSettings s{marched.field, std::move(function)};
    s.unit_distance = 1;
    return marched(s, {-1, 0.4, 0.3}, {2, 0.4, 0.3}, kind);
  };
  for (const int kind : {0, 1, 2}) {
    marched.set([](std::size_t) { return 3.0; });
    EXPECT_EQ(look(constant_function(0), kind).alpha, 0);
    EXPECT_GE(look(constant_function(1), kind).alpha, render::saturated);
    // A step exactly at the constant's value: the value belongs above it.
    const auto step_at = [](double v, double below, double above) {
      return TransferFunction(render::ColorMap::built_in("viridis"), 0, 6,
                              {{0, below}, {v, below}, {v, above}, {6, above}});
    };
    EXPECT_NEAR(look(step_at(2.9, 0, 0.5), kind).alpha, 0.5, 1e-6);
    EXPECT_NEAR(look(step_at(3, 0, 0.5), kind).alpha, 0.5, 1e-6);
    EXPECT_EQ(look(step_at(3.1, 0, 0.5), kind).alpha, 0);
    // A range of one value.
    EXPECT_NEAR(look({render::ColorMap::built_in("viridis"), 3, 3, {{3, 0.5}}}, kind).alpha, 0.5,
                1e-6);
    marched.set([](std::size_t) { return std::nan(""); });
    EXPECT_EQ(look(constant_function(0.5), kind).alpha, 0);
    TransferFunction shown = constant_function(0.1);
    shown.set_nan_opacity(0.5);
    EXPECT_NEAR(look(shown, kind).alpha, 0.5, 1e-6);
    // NaN in one half: all of the cells that touch it, up to three of four along the ray, and all
    // of the farther half. Crooked cells reach a tenth farther.
    marched.set([&](std::size_t v) {
      return marched.mesh.cells.vertices[v].x >= 0.5 ? std::nan("") : 1.0;
    });
    const double seen = look(constant_function(0.5), kind).alpha;
    EXPECT_GE(seen, 1 - std::pow(0.5, 0.25) - 0.06) << kind;
    EXPECT_LE(seen, 1 - std::pow(0.5, 0.5) + 0.06) << kind;
    marched.set([](std::size_t v) { return v % 2 ? HUGE_VAL : -HUGE_VAL; });
    EXPECT_LE(look(constant_function(0.5), kind).alpha, 0.51) << kind;
  }
}

TEST(VolumeHard, NothingOpaqueConstantAndNaN) {
  for (const Shape shape : all_shapes)
    for (const double jitter : {0.0, 0.2}) {
      SCOPED_TRACE(testing::Message() << mesh::shape_name(shape) << ", jitter " << jitter);
      Marched marched(placings[0], shape, jitter);
      expect_extremes_right(marched);
    }
}

/// Every sample of a constant is that constant, to the bit, wherever it lies in a crooked cell:
/// none falls below a step that stands there, as at rest before a run's first cycle.
TEST(VolumeHard, AStepAtAConstantIsNotPartedByRounding) {
  for (const Shape shape : all_shapes) {
    PlacedMesh mesh(placed(4, shape, {1, 1, 1}, {0, 0, 0}));
    const render::ScalarField field =
        mesh.field(std::vector<double>(mesh.cells.vertices.size(), 0.1));
    for (const int kind : {0, 1, 2}) {
      const auto image = [&](std::vector<OpacityPoint> opacity) {
        render::FrameSettings frame = box_frame(64);
        frame.volume = VolumeSettings{
            field, {render::ColorMap::built_in("viridis"), 0, 1, std::move(opacity)}};
        frame.volume->preintegrated = kind == 1;
        if (kind == 2)
          frame.volume->tolerance = 0.01;
        return render_frame(mesh.committed.sampler(), frame, mesh.committed.threads,
                            mesh.committed.memory)
            .color;
      };
      const core::Image step = image({{0, 0}, {0.1, 0}, {0.1, 0.5}, {1, 0.5}}),
                        plain = image({{0, 0.5}, {1, 0.5}});
      ASSERT_GT(plain.pixel(32, 32)[1], 0.01f);
      float most = 0;
      for (int y = 0; y < 64; ++y)
        for (int x = 0; x < 64; ++x)
          most = std::max(most, std::fabs(step.pixel(x, y)[1] - plain.pixel(x, y)[1]));
      // In floats; with a tolerance in other, smaller steps.
      EXPECT_LE(most, kind == 2 ? 1e-4 : 1e-6) << mesh::shape_name(shape) << ", kind " << kind;
    }
  }
}

TEST(VolumeHard, MeshesWithoutThicknessAndImagesOfOnePixel) {
  for (const Placing& placing : {Placing{"a plane", 4, {1, 1, 0}, {0, 0, 0.5}},
                                 Placing{"a line", 4, {1, 0, 0}, {0, 0, 0}}}) {
    Marched marched(placing);
    marched.set([](std::size_t) { return 0.5; });
    for (const int kind : {0, 1, 2}) {
      const VolumeSettings s{marched.field, constant_function(0.6, 0.5)};
      const render::RayState ray = marched(s, {0.4, 0.4, 0}, {0.5, 0.4, 0}, kind);
      EXPECT_GE(ray.alpha, 0);
      EXPECT_LE(ray.alpha, 1);
      render::FrameSettings frame = box_frame(1);
      frame.volume = s;
      frame.volume->preintegrated = kind == 1;
      if (kind == 2)
        frame.volume->tolerance = 0.1;
      const core::Image image =
          render_frame(marched.mesh.committed.sampler(), frame, marched.mesh.committed.threads,
                       marched.mesh.committed.memory)
              .color;
      EXPECT_EQ(image.pixel(0, 0)[0], 0); // seen at an angle: no length at all
      EXPECT_EQ(image.pixel(0, 0)[3], 1);
    }
  }
  Marched marched(placings[0]);
  marched.set([](std::size_t) { return 0.5; });
  render::FrameSettings frame = box_frame(1);
  frame.volume = VolumeSettings{marched.field, constant_function(1.0, 0.5)};
  const core::Image image =
      render_frame(marched.mesh.committed.sampler(), frame, marched.mesh.committed.threads,
                   marched.mesh.committed.memory)
          .color;
  EXPECT_NEAR(image.pixel(0, 0)[0], 0.5, 1e-3);
}

} // namespace
} // namespace insitu::test

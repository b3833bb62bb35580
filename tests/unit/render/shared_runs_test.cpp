// Frames of a mesh that is spread over processes with `compositing: standard`, beside those of one.
#include "render/color/color.h"
#include "unit/render/shared_frames.h"

namespace insitu::test {
namespace {

using render::Compositing;

/// In each channel a difference of less than 1/255, and of files of 8 bits one step at most.
///
/// All samples are those of the lattice of one process, so what differs is the sums of floats, in
/// an order of their own (some 1e-5), and where a ray ends: what is behind an opacity of 0.999
/// adds 0.001 at most. Returns the largest difference.
double expect_near(const Drawn& one, const Drawn& several) {
  EXPECT_EQ(one.color.size(), several.color.size());
  double most = 0;
  std::size_t seen = 0, far = 0, steps = 0;
  const auto step_of = [](float c) {
    return std::lround(255 * render::srgb_of_linear(std::clamp(double(c), 0.0, 1.0)));
  };
  for (std::size_t i = 0; i < one.color.size(); ++i) {
    const double difference = std::fabs(double(one.color[i]) - double(several.color[i]));
    most = std::max(most, difference);
    far += !(difference < 1.0 / 255);
    if (i % 4 == 3)
      continue;
    steps += std::labs(step_of(one.color[i]) - step_of(several.color[i])) > 1;
    seen += one.color[i] > 0;
  }
  EXPECT_GT(seen, one.color.size() / 4 / 20);
  EXPECT_EQ(far, 0u) << most;
  EXPECT_EQ(steps, 0u);
  return most;
}

FrameSettings standard_frame() {
  FrameSettings s = frame();
  s.depth = s.cell = false;
  return s;
}

Drawn by_standard(const TestMesh& whole, const Show& show, int processes, const Partition& parts,
                  bool with_halo = false, std::size_t most_bytes = std::size_t(32) << 20) {
  return on_several(whole, show, processes, parts, with_halo, most_bytes, Compositing::standard);
}

void expect_all_near(const TestMesh& whole, const Show& show, int seed, bool with_halo = false) {
  constexpr int counts[] = {2, 3, 4, 8};
  const Drawn one = on_one(whole, show);
  for (const int k : {0, 1}) {
    const int processes = counts[(seed + 2 * k) % 4];
    const Partition& parts = partitions()[std::size_t(seed + seed / 5 + k) % partitions().size()];
    SCOPED_TRACE(testing::Message() << processes << " processes, " << parts.name);
    expect_near(one, by_standard(whole, show, processes, parts, with_halo));
  }
}

TEST(SharedRuns, VolumesAreNearlyThoseOfOneProcess) {
  int seed = 0;
  for (const Shape shape : shapes) {
    const TestMesh whole = box_cells(6, shape, 0.25);
    for (const int mode : {0, 1, 2, 3, 4, 5, 6}) {
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", mode " << mode);
      expect_all_near(
          whole,
          [&](const ScalarField& f, const ScalarField& c) {
            FrameSettings s = standard_frame();
            s.volume = soft(mode == 4 ? c : f);
            s.volume->preintegrated = mode == 1 || mode == 3 || mode == 6;
            s.volume->shading = mode == 2 || mode == 3;
            if (mode == 3)
              s.clips.push_back({render::Clip::Kind::sphere, {0.5, 0.5, 0.9}, {}, 0.3, false});
            if (mode >= 5) { // nearly all rays are saturated, here and there
              s.volume->unit_distance = 0.03;
              s.background = {1, 1, 1};
            }
            return s;
          },
          seed++);
    }
  }
}

/// Hits part what processes composite, between samples and within their steps.
TEST(SharedRuns, SurfacesAmongTheSamples) {
  int seed = 0;
  for (const Shape shape : shapes) {
    const TestMesh whole = box_cells(6, shape, 0.25);
    for (const int mode : {0, 1, 2, 3}) {
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", mode " << mode);
      expect_all_near(
          whole,
          [&](const ScalarField& f, const ScalarField& c) {
            FrameSettings s = standard_frame();
            s.volume = soft(f);
            s.volume->preintegrated = mode == 1 || mode == 3;
            s.isosurfaces.push_back({f, {0.35, 0.5, 0.55, 0.7}, mode == 2 ? 1.0 : 0.3});
            s.outline = render::OutlineSettings{};
            if (mode == 3) {
              s.boundary = render::BoundarySettings{
                  0.3, render::ColorByField{c, {render::ColorMap::built_in("viridis"), 0, 1, {}}}};
              s.volume->shading = true;
              s.lighting.lights.push_back({render::Light::Kind::point, {0.2, 0.4, 1.5}});
              s.clips.push_back({render::Clip::Kind::plane, {0.3, 0, 0}, {-1, 0.2, 0}});
            }
            return s;
          },
          seed++, true);
    }
  }
}

/// The ways in which rays are unlike others; along the axes samples lie on seams, so that two
/// processes have them.
TEST(SharedRuns, RaysOfAllKinds) {
  int seed = 0;
  for (const char* kind : {"orthographic", "several a pixel", "thin", "from within", "short groups",
                           "few bytes at a time", "along the axes", "many rounds"}) {
    SCOPED_TRACE(kind);
    const std::string is = kind;
    const TestMesh whole = box_cells(6, Shape::tetrahedron, is == "along the axes" ? 0 : 0.25);
    for (const int mode : {0, 1, 2}) {
      const Show show = [&](const ScalarField& f, const ScalarField& c) {
        FrameSettings s = standard_frame();
        s.volume = soft(mode == 2 ? c : f);
        s.volume->preintegrated = mode == 1;
        if (mode == 1)
          s.isosurfaces.push_back({f, {0.7}, 0.6});
        if (is == "orthographic" || is == "along the axes")
          s.camera.orthographic_height = 1.4;
        if (is == "along the axes") { // the middle column and row of pixels in planes of vertices
          s.width = s.height = 71;
          s.camera.position = {0.5, 0.5, 3};
        }
        if (is == "several a pixel")
          s.samples_per_pixel = 3;
        if (is == "thin")
          s.volume->step = 0.8;
        if (is == "from within")
          s.camera.position = {0.45, 0.4, 0.8};
        if (is == "short groups")
          s.volume->sample_group = 5;
        if (is == "many rounds")
          s.volume->step = 0.002;
        return s;
      };
      const Drawn one = on_one(whole, show);
      for (const int processes : {2, 4}) {
        const Partition& parts = partitions()[std::size_t(seed++) % partitions().size()];
        SCOPED_TRACE(testing::Message()
                     << "mode " << mode << ", " << processes << " processes, " << parts.name);
        if (is == "along the axes") {
          EXPECT_EQ(differing(one.color, on_several(whole, show, processes, parts).color), 0u);
        }
        expect_near(one, by_standard(whole, show, processes, parts, false,
                                     is == "few bytes at a time" ? 1 : std::size_t(32) << 20));
      }
    }
  }
}

/// What needs each sample is drawn as by `exact`, and so is all of one process.
TEST(SharedRuns, ExactWhereItHasToBe) {
  const TestMesh whole = box_cells(6, Shape::hexahedron, 0.2);
  for (const char* what : {"depth", "shadows", "one process"}) {
    SCOPED_TRACE(what);
    const std::string is = what;
    const Show show = [&](const ScalarField& f, const ScalarField&) {
      FrameSettings s = standard_frame();
      s.volume = soft(f);
      s.depth = is == "depth";
      if (is == "shadows") {
        s.volume->shading = true;
        s.isosurfaces.push_back({f, {0.7}, 0.6});
        s.lighting.volume_shadows = true;
        s.lighting.lights.push_back({render::Light::Kind::point, {0.2, 0.4, 1.5}});
      }
      return s;
    };
    const int processes = is == "one process" ? 1 : 3;
    expect_equal(on_one(whole, show), by_standard(whole, show, processes, partitions()[0]));
    const ScalarField none;
    EXPECT_EQ(render::why_exact(show(none, none)) == nullptr, processes == 1);
  }
}

/// All cells on the process that is not the root: one run a ray, and tile, whose pixels are the
/// root's (design/scale.md).
TEST(SharedRuns, BytesAreThoseOfTheModel) {
  const TestMesh whole = box_cells(8, Shape::hexahedron, 0.2);
  const Show show = [&](const ScalarField& f, const ScalarField&) {
    FrameSettings s = box_frame(64);
    s.volume = soft(f);
    s.volume->function = {render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0, 0.01}, {1, 0.02}}};
    return s;
  };
  std::int64_t bytes[2] = {0, 0};
  std::mutex mutex;
  for (const Compositing compositing : {Compositing::exact, Compositing::standard})
    run_processes(2, [&](parallel::World& world) {
      PartedMesh mesh(whole, partitions()[3].deal(2), world.rank());
      const ScalarField f = mesh.field("f", INSITU_VERTEX, blob);
      mesh.meet_others(world, false);
      render::Structures structures(mesh.committed.memory);
      const core::Threads threads(1);
      structures.begin(mesh.committed.sampler(), 0, 0, threads);
      FramePart part = mesh.part(world);
      part.compositing = compositing;
      FrameStatistics done;
      render::render_shared_frame(part, mesh.sampler(), show(f, f), structures, threads, &done);
      const std::lock_guard lock(mutex);
      bytes[int(compositing)] += done.bytes_sent;
    });
  std::int64_t rays = 0; // of the box, by at least a step
  const FrameSettings s = box_frame(64);
  const render::RayGenerator generator(s.camera, 64, 64);
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) {
      const auto [near, far] = box_stretch(generator(x, y));
      rays += far - near > 0.07;
    }
  EXPECT_GT(rays, 1000);
  // Some rays pass corners by less than a step; none is of two rounds.
  EXPECT_NEAR(double(bytes[int(Compositing::standard)]), 20.0 * double(rays) + 12,
              0.05 * 20 * double(rays));
  EXPECT_LT(3 * bytes[int(Compositing::standard)], bytes[int(Compositing::exact)]); // 10 a ray
}

} // namespace
} // namespace insitu::test

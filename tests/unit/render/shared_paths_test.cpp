// Path traced frames of a mesh that is spread over processes are those of one process, to the bit.
#include <atomic>
#include <mutex>

#include "core/status.h"
#include "unit/render/shared_frames.h"

namespace insitu::test {
namespace {

using render::Light;
using render::Scattering;

/// All kinds of lights, and paths that scatter forwards.
void trace(FrameSettings& s, int samples) {
  s.path_tracing.emplace().samples = samples;
  s.path_tracing->anisotropy = 0.3;
  using Kind = Light::Kind;
  s.lighting.lights = {{Kind::dome, {}, {0.3f, 0.4f, 0.5f}},
                       {Kind::directional, {1, 2, 1}, {1, 1, 1}},
                       {Kind::point, {1.5, 0.5, 1.2}, {1, 1, 1}},
                       {Kind::head, {}, {0.2f, 0.2f, 0.2f}}};
}

render::IsosurfaceSettings surface(const ScalarField& field, double value, double opacity) {
  render::IsosurfaceSettings of{field, {value}, opacity};
  of.color = render::Color{0.7f, 0.5f, 0.3f};
  return of;
}

TEST(SharedPaths, FramesAreThoseOfOneProcess) {
  for (int seed = 0; seed < 9; ++seed) {
    const int mode = seed % 5;
    const Shape shape = shapes[seed % 4];
    SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", mode " << mode);
    expect_same(
        box_cells(6, shape, 0.25),
        [&](const ScalarField& f, const ScalarField& c) {
          FrameSettings s = frame();
          s.volume = soft(mode == 1 ? c : f);
          trace(s, 4);
          if (mode == 1)
            s.path_tracing->scattering = Scattering::single;
          if (mode == 2)
            s.path_tracing->scattering = Scattering::none;
          if (mode == 3) { // surfaces that end camera rays alone
            s.isosurfaces.push_back(surface(f, 0.7, 0.5));
            s.clips.push_back({render::Clip::Kind::plane, {0.3, 0, 0}, {-1, 0.2, 0}});
          }
          if (mode == 4)
            s.path_tracing->shows_dome = true;
          return s;
        },
        seed);
  }
}

/// Shadow rays and scattered light meet surfaces, which are lit by rays of their own.
TEST(SharedPaths, MeetSurfaces) {
  for (const int mode : {0, 1, 2, 3}) {
    const Shape shape = mode % 2 ? Shape::hexahedron : Shape::tetrahedron;
    SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", mode " << mode);
    expect_same(
        box_cells(6, shape, 0.2),
        [&](const ScalarField& f, const ScalarField& c) {
          FrameSettings s = frame();
          s.volume = soft(f);
          trace(s, 1);
          s.lighting.volume_shadows = true;
          s.lighting.enabled = mode > 0;
          s.lighting.shadows = mode > 1;
          s.lighting.occlusion_samples = mode == 2 ? 2 : 0;
          s.isosurfaces.push_back(surface(f, 0.75, 0.6));
          if (mode == 1)
            s.isosurfaces.push_back(surface(c, 0.5, 1));
          if (mode == 2)
            s.isosurfaces.back().normals = render::Normals::central;
          if (mode == 3) {
            s.boundary = render::BoundarySettings{0.2, render::Color{0.4f, 0.5f, 0.6f}};
            s.clips.push_back({render::Clip::Kind::sphere, {0.5, 0.5, 0.9}, {}, 0.3, false});
          }
          return s;
        },
        mode, true);
  }
}

/// The ways in which the rays and paths of a frame are unlike others.
TEST(SharedPaths, RaysOfAllKinds) {
  const TestMesh whole = box_cells(6, Shape::tetrahedron, 0.25);
  int seed = 0;
  for (const char* kind : {"orthographic", "several a pixel", "from within", "few bytes at a time",
                           "many waves", "short paths"}) {
    SCOPED_TRACE(kind);
    const std::string is = kind;
    const Show show = [&](const ScalarField& f, const ScalarField&) {
      FrameSettings s = frame();
      s.volume = soft(f);
      trace(s, 5);
      if (is == "orthographic")
        s.camera.orthographic_height = 1.4;
      if (is == "several a pixel")
        s.samples_per_pixel = 3;
      if (is == "from within")
        s.camera.position = {0.45, 0.4, 0.8};
      if (is == "many waves")
        s.path_tracing->samples = 33;
      if (is == "short paths")
        s.path_tracing->max_bounces = 1;
      return s;
    };
    const Drawn one = on_one(whole, show);
    for (const int processes : {seed % 4 ? 4 : 1, 8}) {
      const Partition& parts = partitions()[std::size_t(seed++) % partitions().size()];
      SCOPED_TRACE(testing::Message() << processes << " processes, " << parts.name);
      const Drawn several = on_several(whole, show, processes, parts, false,
                                       is == "few bytes at a time" ? 1 : std::size_t(32) << 20);
      expect_equal(one, several);
    }
  }
}

/// Three frames whose samples add up, on one process and on several.
std::vector<Drawn> added_up(int processes, int samples_per_pixel) {
  const TestMesh whole = box_cells(5, Shape::hexahedron, 0.2);
  std::vector<Drawn> drawn;
  run_processes(processes, [&](parallel::World& world) {
    PartedMesh mesh(whole, partitions()[0].deal(processes), world.rank());
    const ScalarField f = mesh.field("f", INSITU_VERTEX, blob);
    mesh.meet_others(world, false);
    render::Structures structures(mesh.committed.memory);
    const core::Threads threads(1);
    structures.begin(mesh.committed.sampler(), 0, 0, threads);
    render::PathSums sums(mesh.committed.memory);
    for (int i = 0; i < 3; ++i) {
      FrameSettings s = frame();
      s.samples_per_pixel = samples_per_pixel;
      s.volume = soft(mesh.known(f));
      trace(s, 4);
      s.path_tracing->sums = &sums;
      const FrameImages images = processes == 1
                                     ? render::render_frame(mesh.sampler(), s, structures, threads)
                                     : render::render_shared_frame(mesh.part(world), mesh.sampler(),
                                                                   s, structures, threads);
      EXPECT_EQ(sums.samples, 4 * (i + 1));
      EXPECT_EQ(sums.pixels.empty(), !world.is_root());
      if (world.is_root())
        drawn.push_back(kept(images));
    }
  });
  return drawn;
}

TEST(SharedPaths, SamplesAddUpAtTheRoot) {
  for (const int samples : {1, 3}) {
    const std::vector<Drawn> one = added_up(1, samples), several = added_up(3, samples);
    for (std::size_t i = 0; i < 3; ++i)
      expect_equal(one[i], several[i]);
    EXPECT_GT(differing(one[1].color, one[2].color), 0u);
  }
}

/// One tile, all cells on the process that does not own it: every place crosses, and every value
/// comes back, as design/parallel.md counts them.
TEST(SharedPaths, BytesAreThoseOfTheModel) {
  const TestMesh whole = box_cells(6, Shape::hexahedron, 0);
  std::atomic<std::int64_t> bytes{0};
  render::PathCounts paths;
  std::int64_t exchanges = 0;
  run_processes(2, [&](parallel::World& world) {
    PartedMesh mesh(whole, partitions()[3].deal(2), world.rank());
    const ScalarField f = mesh.field("f", INSITU_VERTEX, [](const Vec3d&) { return 0.8; });
    mesh.meet_others(world, false);
    render::Structures structures(mesh.committed.memory);
    const core::Threads threads(1);
    structures.begin(mesh.committed.sampler(), 0, 0, threads);
    FrameSettings s = box_frame(64);
    s.volume = soft(f);
    trace(s, 8);
    FrameStatistics done;
    render::render_shared_frame(mesh.part(world), mesh.sampler(), s, structures, threads, &done);
    bytes += done.bytes_sent;
    if (world.is_root()) {
      paths = done.paths;
      exchanges = done.exchanges;
    }
  });
  EXPECT_GT(paths.locations, 100000);
  EXPECT_EQ(paths.violations, 0);
  // A place and its value, and a bit; 24 a round for parcels. Pixels do not cross.
  const double expected =
      (24 + 16 + 1.0 / 8) * double(paths.locations) + 24.0 * double(exchanges) / 2;
  EXPECT_LE(double(bytes), 1.01 * expected); // bits come in words
  EXPECT_GT(double(bytes), 0.99 * expected); // places on the mesh's faces may be outside
}

/// What paths do is counted over all processes.
TEST(SharedPaths, CountsAreThoseOfOneProcess) {
  const TestMesh whole = box_cells(5, Shape::wedge, 0.2);
  const Show show = [&](const ScalarField& f, const ScalarField&) {
    FrameSettings s = frame();
    s.volume = soft(f);
    trace(s, 3);
    s.path_tracing->max_bounces = 2;
    return s;
  };
  const auto counted = [&](int processes) {
    return on_several(whole, show, processes, partitions()[1]).done.paths;
  };
  const render::PathCounts one = counted(1), several = counted(4);
  EXPECT_GT(one.cut, 0);
  EXPECT_EQ(std::memcmp(&one, &several, sizeof one), 0);
}

/// A process that fails while it answers ends the frame for all.
TEST(SharedPaths, FailuresAreAgreed) {
  const TestMesh whole = box_cells(3, Shape::hexahedron, 0);
  for (const int failing : {0, 2})
    run_processes(3, [&](parallel::World& world) {
      PartedMesh mesh(whole, partitions()[0].deal(3), world.rank());
      const ScalarField f = mesh.field("f", INSITU_VERTEX, blob);
      mesh.meet_others(world, false);
      render::Structures structures(mesh.committed.memory);
      const core::Threads threads(1);
      structures.begin(mesh.sampler(), 0, 0, threads);
      FrameSettings s = frame();
      s.volume = soft(f);
      trace(s, 2);
      std::atomic<int> asked{0};
      const FramePart part{world, std::int64_t(mesh.numbers.size()), [&](std::int64_t flat) {
                             if (world.rank() == failing && ++asked > 100)
                               throw core::Error(INSITU_ERROR_INTERNAL, "a test fails");
                             return mesh.numbers[std::size_t(flat)];
                           }};
      try {
        render::render_shared_frame(part, mesh.sampler(), s, structures, threads);
        ADD_FAILURE() << "no error";
      } catch (const parallel::AgreedError& e) {
        EXPECT_EQ(e.status(), INSITU_ERROR_INTERNAL);
        EXPECT_NE(std::string(e.what()).find("a test fails"), std::string::npos) << e.what();
      }
    });
}

} // namespace
} // namespace insitu::test

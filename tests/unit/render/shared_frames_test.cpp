// Frames of a mesh that is spread over processes are those of one process, to the bit.
#include <atomic>
#include <cstring>
#include <gtest/gtest.h>
#include <mutex>

#include "core/status.h"
#include "output/image/png.h"
#include "render/structures/structures.h"
#include "unit/parallel/threaded_world.h"
#include "unit/render/parted_mesh.h"

namespace insitu::test {
namespace {

using render::FrameImages;
using render::FramePart;
using render::FrameSettings;
using render::FrameStatistics;
using render::ScalarField;

double blob(const Vec3d& p) {
  const Vec3d d = p - Vec3d{0.4, 0.5, 0.6};
  return std::max(0.0, 1 - 4 * dot(d, d));
}
double waves(const Vec3d& p) {
  return 0.5 + 0.25 * std::sin(9 * p.x + 2 * p.y) + 0.25 * std::cos(7 * p.z - 3 * p.y);
}

/// How cells are dealt out to so many processes.
struct Partition {
  const char* name;
  std::function<Deal(int processes)> deal;
  int pieces = 1;
};
const std::vector<Partition>& partitions() {
  static const std::vector<Partition> all = {
      {"slabs",
       [](int n) {
         return [n](std::size_t, const Vec3d& p) { return std::clamp(int(p.x * n), 0, n - 1); };
       }},
      {"boxes",
       [](int n) {
         return [n](std::size_t, const Vec3d& p) {
           return (int(p.x > 0.45) + 2 * int(p.y > 0.55) + 4 * int(p.z > 0.5)) % n;
         };
       },
       3},
      {"random",
       [](int n) {
         return [n](std::size_t cell, const Vec3d&) {
           return int(core::random_unit(7, cell, 0) * n) % n;
         };
       }},
      {"all on the last", [](int n) { return [n](std::size_t, const Vec3d&) { return n - 1; }; }},
      {"none on the second", [](int n) {
         return [n](std::size_t, const Vec3d& p) {
           const int process = std::clamp(int(p.z * n), 0, n - 1);
           return process == 1 ? 0 : process;
         };
       }}};
  return all;
}

/// What a frame shows, given the fields "f" of vertices and "c" of cells.
using Show = std::function<FrameSettings(const ScalarField& f, const ScalarField& c)>;

struct Drawn {
  std::vector<float> color, depth;
  std::vector<std::int64_t> cell;
  FrameStatistics done;
};

Drawn kept(const FrameImages& images) {
  return {{images.color.rgba.begin(), images.color.rgba.end()},
          {images.depth.begin(), images.depth.end()},
          {images.cell.begin(), images.cell.end()},
          {}};
}

Drawn on_one(const TestMesh& whole, const Show& show) {
  PartedMesh mesh(
      whole, [](std::size_t, const Vec3d&) { return 0; }, 0);
  const ScalarField c = mesh.field("c", INSITU_CELL, waves);
  const FrameSettings settings = show(mesh.field("f", INSITU_VERTEX, blob), c);
  Drawn drawn = kept(render::render_frame(mesh.sampler(), settings, core::Threads(2),
                                          mesh.committed.memory, nullptr));
  return drawn;
}

Drawn on_several(const TestMesh& whole, const Show& show, int processes, const Partition& parts,
                 bool with_halo = false, std::size_t most_bytes = std::size_t(32) << 20) {
  Drawn drawn;
  run_processes(processes, [&](parallel::World& world) {
    PartedMesh mesh(whole, parts.deal(processes), world.rank(), parts.pieces);
    const ScalarField c = mesh.field("c", INSITU_CELL, waves);
    const ScalarField f = mesh.field("f", INSITU_VERTEX, blob);
    mesh.meet_others(world, with_halo);
    const FrameSettings settings = show(mesh.known(f), mesh.known(c));
    render::Structures structures(mesh.committed.memory);
    const core::Threads threads(1);
    structures.begin(mesh.committed.sampler(), 0, 0, threads);
    FramePart part = mesh.part(world);
    part.has_halo |= processes == 1;
    part.most_bytes = most_bytes;
    FrameStatistics done;
    const FrameImages images =
        render::render_shared_frame(part, mesh.sampler(), settings, structures, threads, &done);
    if (world.is_root()) {
      drawn = kept(images);
      drawn.done = done;
    } else {
      EXPECT_TRUE(images.color.rgba.empty());
    }
  });
  return drawn;
}

template <class T>
std::size_t differing(const std::vector<T>& a, const std::vector<T>& b) {
  if (a.size() != b.size())
    return std::max(a.size(), b.size());
  std::size_t count = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    count += std::memcmp(&a[i], &b[i], sizeof(T)) != 0;
  return count;
}

void expect_same(const TestMesh& whole, const Show& show, int seed = 0, bool with_halo = false) {
  const Drawn one = on_one(whole, show);
  std::size_t seen = 0; // pixels that are not background
  for (std::size_t i = 0; i < one.color.size(); i += 4)
    seen += one.color[i] > 0;
  EXPECT_GT(seen, one.color.size() / 4 / 20);
  if (const char* dir = std::getenv("TMP_PICTURES")) {
    static int number = 0;
    core::Image image(70, 66);
    std::copy(one.color.begin(), one.color.end(), image.rgba.begin());
    output::write_png(std::string(dir) + "/p" + std::to_string(number++) + ".png", image, false);
  }
  for (const int processes : {1, 2, 3, 4, 8}) {
    const Partition& parts = partitions()[std::size_t(seed++) % partitions().size()];
    SCOPED_TRACE(testing::Message() << processes << " processes, " << parts.name);
    const Drawn several = on_several(whole, show, processes, parts, with_halo);
    EXPECT_EQ(differing(one.color, several.color), 0u);
    EXPECT_EQ(differing(one.depth, several.depth), 0u);
    EXPECT_EQ(differing(one.cell, several.cell), 0u);
  }
}

FrameSettings frame() {
  FrameSettings s = box_frame(70);
  s.height = 66;
  s.depth = s.cell = true;
  return s;
}

render::VolumeSettings soft(const ScalarField& field) {
  render::VolumeSettings volume{
      field,
      {render::ColorMap::built_in("viridis"), 0.0, 1.0, {{0, 0}, {0.3, 0}, {0.6, 0.1}, {1, 0.7}}}};
  volume.unit_distance = 0.1;
  return volume;
}

constexpr Shape shapes[] = {Shape::hexahedron, Shape::tetrahedron, Shape::wedge, Shape::pyramid};

TEST(SharedFrames, VolumesAreThoseOfOneProcess) {
  int seed = 0;
  for (const Shape shape : shapes) {
    const TestMesh whole = box_cells(6, shape, 0.25);
    for (const int mode : {0, 1, 2, 3, 4}) {
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", mode " << mode);
      expect_same(
          whole,
          [&](const ScalarField& f, const ScalarField& c) {
            FrameSettings s = frame();
            s.volume = soft(mode == 4 ? c : f);
            s.volume->preintegrated = mode == 1 || mode == 3;
            s.volume->shading = mode == 2 || mode == 3;
            if (mode == 3)
              s.clips.push_back({render::Clip::Kind::sphere, {0.5, 0.5, 0.9}, {}, 0.3, false});
            return s;
          },
          seed++);
    }
  }
}

TEST(SharedFrames, IsosurfacesAreThoseOfOneProcess) {
  int seed = 0;
  for (const Shape shape : shapes) {
    const TestMesh whole = box_cells(6, shape, 0.25);
    for (const int mode : {0, 1, 2, 3}) {
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", mode " << mode);
      expect_same(
          whole,
          [&](const ScalarField& f, const ScalarField& c) {
            FrameSettings s = frame();
            s.isosurfaces.push_back({f, {0.35, 0.7}, mode == 1 ? 0.4 : 1.0});
            if (mode == 1)
              s.isosurfaces[0].color =
                  render::ColorByField{c, {render::ColorMap::built_in("viridis"), 0, 1, {}}};
            if (mode == 2) {
              s.isosurfaces[0].search = render::RootSearch::neubauer;
              s.outline = render::OutlineSettings{};
            }
            if (mode == 3) {
              s.isosurfaces[0].opacity = 0.5;
              s.volume = soft(f);
              s.volume->preintegrated = shape != Shape::wedge;
              s.clips.push_back({render::Clip::Kind::plane, {0.3, 0, 0}, {-1, 0.2, 0}});
            }
            return s;
          },
          seed++);
    }
  }
}

/// What hangs on the cells around vertices, or on whether there is a cell beyond a face.
TEST(SharedFrames, WhatTheCellsOfOthersTell) {
  int seed = 0;
  for (const Shape shape : shapes) {
    const TestMesh whole = box_cells(6, shape, 0.2);
    for (const int mode : {0, 1, 2, 3}) {
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", mode " << mode);
      expect_same(
          whole,
          [&](const ScalarField& f, const ScalarField& c) {
            FrameSettings s = frame();
            const render::ColorByField by{mode == 3 ? f : c,
                                          {render::ColorMap::built_in("viridis"), 0, 1, {}}};
            if (mode == 0 || mode == 1) { // smooth normals, and averages of a cell field
              s.isosurfaces.push_back({mode == 0 ? f : c, {0.5}});
              s.isosurfaces[0].normals =
                  mode == 0 ? render::Normals::smooth : render::Normals::cell;
            }
            if (mode == 1) {
              s.boundary = render::BoundarySettings{0.3, by};
              s.clips.push_back({render::Clip::Kind::plane, {0.3, 0, 0}, {-1, 0.2, 0}});
            }
            if (mode == 2)
              s.boundary = render::BoundarySettings{1, by};
            if (mode == 3) {
              s.boundary = render::BoundarySettings{0.2, by};
              s.volume = soft(f);
              s.volume->preintegrated = true;
              s.volume->shading = true;
            }
            return s;
          },
          seed++, true);
    }
  }
}

/// A triangle beside the mesh, which casts a shadow on it.
render::BodySettings triangle(double opacity) {
  render::BodySettings body;
  auto list = std::make_shared<render::TriangleList>();
  list->source = "a triangle";
  list->corners.assign({Vec3d{0.2, 0.2, 1.3}, Vec3d{0.9, 0.3, 1.2}, Vec3d{0.4, 0.9, 1.1}});
  body.triangles = list;
  body.opacity = opacity;
  return body;
}

/// Shadows and ambient occlusion: rays of light go to the processes whose cells they may meet.
TEST(SharedFrames, RaysOfLight) {
  using render::Light;
  int seed = 0;
  for (const Shape shape : shapes) {
    const TestMesh whole = box_cells(6, shape, 0.2);
    for (const int mode : {0, 1, 2, 3, 4, 5}) {
      if (++seed % 2 == 0) // the other modes with the next shape
        continue;
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", mode " << mode);
      expect_same(
          whole,
          [&](const ScalarField& f, const ScalarField& c) {
            FrameSettings s = frame();
            s.lighting.lights = {{Light::Kind::directional, {0.3, 0.2, 1}},
                                 {Light::Kind::point, {0.5, 0.4, 1.6}, {0.5f, 0.7f, 0.9f}}};
            s.lighting.shadows = mode != 1;
            s.isosurfaces.push_back({f, {0.2, 0.5}, mode == 2 || mode == 4 ? 0.4 : 1.0});
            if (mode == 0)
              s.isosurfaces[0].normals = render::Normals::smooth;
            if (mode == 1 || mode == 2)
              s.lighting.occlusion_samples = 5;
            if (mode == 1 || mode == 3) {
              s.boundary = render::BoundarySettings{mode == 1 ? 0.5 : 1.0, {}};
              s.clips.push_back({render::Clip::Kind::plane, {0.3, 0, 0.7}, {0.2, 0.2, 1}});
            }
            if (mode == 2)
              s.bodies = {triangle(1)};
            if (mode == 3) {
              s.bodies = {triangle(0.5)};
              s.lighting.lights = {{Light::Kind::dome}};
            }
            if (mode == 4) {
              s.isosurfaces[0].search = render::RootSearch::cubic;
              s.outline = render::OutlineSettings{};
            }
            if (mode == 5) {
              s.lighting.volume_shadows = true;
              s.bodies = {triangle(0.7)};
              s.isosurfaces[0].values = {0.7};
              s.volume = soft(shape == Shape::pyramid ? c : f);
              s.volume->shading = true;
            }
            return s;
          },
          seed, mode == 0 || mode == 1 || mode == 3);
    }
    ++seed;
  }
}

/// Volumes that are lit by lights at a place, and by those that surfaces hide.
TEST(SharedFrames, LightOnVolumes) {
  using render::Light;
  int seed = 0;
  for (const int mode : {0, 1, 2, 3, 4, 5}) {
    const TestMesh whole = box_cells(6, shapes[mode % 4], 0.2);
    SCOPED_TRACE(testing::Message() << "mode " << mode);
    expect_same(
        whole,
        [&](const ScalarField& f, const ScalarField& c) {
          FrameSettings s = frame();
          s.lighting.lights = {{Light::Kind::point, {0.5, 0.4, 1.6}, {0.5f, 0.7f, 0.9f}}};
          if (mode > 1)
            s.lighting.lights.push_back(
                {mode == 2 ? Light::Kind::dome : Light::Kind::directional, {0.3, 0.2, 1}});
          s.volume = soft(mode == 5 ? c : f); // cells have no gradient
          s.volume->shading = true;
          s.volume->preintegrated = mode % 2 == 0;
          s.lighting.volume_shadows = s.lighting.shadows = mode > 0;
          s.bodies = {triangle(0.7)};
          if (mode > 1)
            s.isosurfaces.push_back({f, {0.7}, mode == 2 ? 0.5 : 1.0});
          if (mode == 3)
            s.volume->step = 0.8; // thin rays
          if (mode == 4)
            s.clips.push_back({render::Clip::Kind::sphere, {0.5, 0.5, 0.9}, {}, 0.3, false});
          return s;
        },
        seed++);
  }
}

/// The ways in which the rays of a frame are unlike others.
TEST(SharedFrames, RaysOfAllKinds) {
  const TestMesh whole = box_cells(6, Shape::tetrahedron, 0.25);
  int seed = 0;
  for (const char* kind : {"orthographic", "several a pixel", "thin", "from within", "short groups",
                           "few bytes at a time", "along the axes"}) {
    SCOPED_TRACE(kind);
    const std::string is = kind;
    const bool integrates = seed % 2 == 0;
    const Show show = [&](const ScalarField& f, const ScalarField&) {
      FrameSettings s = frame();
      s.volume = soft(f);
      s.volume->preintegrated = integrates;
      s.isosurfaces.push_back({f, {0.7}, 0.6});
      if (is == "orthographic" || is == "along the axes")
        s.camera.orthographic_height = 1.4;
      if (is == "along the axes") // through faces of cells, and along the box's
        s.camera.position = {0.5, 0.5, 3};
      if (is == "several a pixel")
        s.samples_per_pixel = 3;
      if (is == "thin")
        s.volume->step = 0.8;
      if (is == "from within")
        s.camera.position = {0.45, 0.4, 0.8};
      if (is == "short groups")
        s.volume->sample_group = 5;
      return s;
    };
    const Drawn one = on_one(whole, show);
    for (const int processes : {1, 3, 4}) {
      const Partition& parts = partitions()[std::size_t(seed++) % partitions().size()];
      SCOPED_TRACE(testing::Message() << processes << " processes, " << parts.name);
      const Drawn several = on_several(whole, show, processes, parts, false,
                                       is == "few bytes at a time" ? 1 : std::size_t(32) << 20);
      EXPECT_EQ(differing(one.color, several.color), 0u);
      EXPECT_EQ(differing(one.depth, several.depth), 0u);
      EXPECT_EQ(differing(one.cell, several.cell), 0u);
    }
  }
}

/// Two tiles, all cells on the process that is not the root, which owns the second: it sends the
/// first one's hits, and the second one's pixels, as design/parallel.md counts them.
TEST(SharedFrames, BytesAreThoseOfTheModel) {
  const TestMesh whole = box_cells(8, Shape::tetrahedron, 0.2);
  std::int64_t hits = 0, bytes = 0, parcels = 0;
  std::mutex mutex;
  run_processes(2, [&](parallel::World& world) {
    PartedMesh mesh(whole, partitions()[3].deal(2), world.rank());
    const ScalarField f = mesh.field("f", INSITU_VERTEX, blob);
    mesh.meet_others(world, false);
    render::Structures structures(mesh.committed.memory);
    const core::Threads threads(1);
    structures.begin(mesh.committed.sampler(), 0, 0, threads);
    FrameSettings s = box_frame(64);
    s.width = 128;
    s.depth = s.cell = true;
    s.isosurfaces.push_back({f, {0.2, 0.5}, 0.5});
    FrameStatistics done;
    render::render_shared_frame(mesh.part(world), mesh.sampler(), s, structures, threads, &done);
    const std::lock_guard lock(mutex);
    if (world.is_root())
      hits = done.hits;
    bytes += done.bytes_sent;
    parcels += done.parcels_sent;
  });
  EXPECT_GT(hits, 2000);
  EXPECT_EQ(parcels, 2);
  const double expected = 80.0 * double(hits) + 4096 * 28 + 4 * 2;
  EXPECT_GE(double(bytes), expected); // twins are sent as well
  EXPECT_LT(double(bytes), 1.1 * expected);
}

/// What is not there yet is refused alike by all, and a process that fails ends the frame for all.
TEST(SharedFrames, FailuresAreAgreed) {
  const TestMesh whole = box_cells(3, Shape::hexahedron, 0);
  for (const int failing : {-1, 0, 2})
    run_processes(3, [&](parallel::World& world) {
      PartedMesh mesh(whole, partitions()[0].deal(3), world.rank());
      const ScalarField f = mesh.field("f", INSITU_VERTEX, blob);
      mesh.meet_others(world, false);
      render::Structures structures(mesh.committed.memory);
      const core::Threads threads(1);
      structures.begin(mesh.sampler(), 0, 0, threads);
      FrameSettings s = frame();
      s.volume = soft(f);
      if (failing < 0)
        s.path_tracing.emplace();
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
        EXPECT_EQ(e.status(), failing < 0 ? INSITU_ERROR_UNSUPPORTED : INSITU_ERROR_INTERNAL);
        const std::string text = e.what();
        EXPECT_NE(text.find(failing < 0 ? "traced paths over several processes are not there yet"
                                        : "a test fails"),
                  std::string::npos)
            << text;
      }
    });
}

} // namespace
} // namespace insitu::test

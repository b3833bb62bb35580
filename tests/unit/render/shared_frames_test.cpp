// Frames of a mesh that is spread over processes are those of one process, to the bit.
#include <atomic>
#include <mutex>

#include "core/status.h"
#include "unit/render/shared_frames.h"

namespace insitu::test {
namespace {

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

/// Normals by the field at places around hits, which other processes may hold: in small boxes and
/// in flat ones, where places lie several cells away.
TEST(SharedFrames, CentralDifferencesReachIntoOtherCells) {
  int seed = 0;
  for (const Shape shape : shapes)
    for (const int mode : {0, 1, 2}) {
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", mode " << mode);
      TestMesh whole = box_cells(6, shape, 0.2);
      for (Vec3d& x : whole.vertices) // many layers near the middle
        if (mode == 1)
          x.y = 0.5 + 4 * (x.y - 0.5) * std::fabs(x.y - 0.5) * std::fabs(x.y - 0.5);
      expect_same(
          whole,
          [&](const ScalarField& f, const ScalarField& c) {
            FrameSettings s = frame();
            s.isosurfaces.push_back({f, {0.35, 0.7}, mode == 0 ? 1.0 : 0.4});
            s.isosurfaces[0].normals = render::Normals::central;
            if (mode == 1) { // beside surfaces that have other normals
              s.isosurfaces.push_back({f, {0.5}, 0.5});
              s.boundary = render::BoundarySettings{0.2, {}};
            }
            if (mode == 2) {
              s.isosurfaces.push_back({c, {0.6}});
              s.isosurfaces[1].normals = render::Normals::central;
              s.lighting.shadows = true;
              s.lighting.occlusion_samples = 2;
            }
            return s;
          },
          seed++, mode > 0);
    }
}

/// Steps by a tolerance hang on macrocells of the whole mesh, of which others may have more cells.
TEST(SharedFrames, StepsByAToleranceAreThoseOfOneProcess) {
  int seed = 0;
  for (const Shape shape : shapes) {
    for (const int mode : {0, 1, 2, 3}) {
      if (++seed % 2 == 0) // the other modes with the next shape
        continue;
      SCOPED_TRACE(testing::Message() << "shape " << int(shape) << ", mode " << mode);
      TestMesh whole = box_cells(6, shape, 0.2);
      for (Vec3d& x : whole.vertices) // cells of many sizes
        if (mode % 2 == 1)
          x.x *= x.x;
      expect_same(
          whole,
          [&](const ScalarField& f, const ScalarField& c) {
            FrameSettings s = frame();
            s.volume = soft(mode == 3 ? c : f);
            s.volume->tolerance = mode == 0 ? 0.02 : 0.2;
            s.volume->skip_empty = mode != 1;
            s.volume->shading = mode == 2;
            if (mode == 1) { // cut, and behind surfaces; lit by a light that hangs on the place
              s.volume->shading = true;
              s.lighting.lights = {{render::Light::Kind::point, {0.5, 0.4, 1.6}}};
              s.isosurfaces.push_back({f, {0.6}, 0.5});
              s.clips.push_back({render::Clip::Kind::sphere, {0.5, 0.5, 0.9}, {}, 0.3, false});
            }
            if (mode == 2) {
              s.volume->sample_group = 5;
              s.samples_per_pixel = 2;
            }
            if (mode == 3) // some rays are thin
              s.volume->step = 0.3;
            return s;
          },
          seed, mode == 1);
    }
    ++seed;
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
      expect_equal(one, several);
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

/// A process that fails ends the frame for all.
TEST(SharedFrames, FailuresAreAgreed) {
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

#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <unistd.h>

#include "../render/render_mesh.h"
#include "core/context.h"
#include "geo/reference_frames.h"
#include "scene/earth/geocentric_view.h"
#include "scene/frames/frame_settings.h"
#include "scene/parse/parse.h"
#include "scene/run/runner.h"
#include "scene_test.h"

/// A sea in longitude and latitude, for frames from space.
namespace insitu::test {

using scene::geocentric_place;

constexpr double west = 10, south = 30, extent = 10, deepest = 4000; // degrees, metres
constexpr int cells_along = 20;
constexpr double degree = 3.14159265358979323846 / 180;

/// Longitude, latitude, height of a place in the unit cube.
inline Vec3d on_earth(const Vec3d& p) {
  return {west + extent * p.x, south + extent * p.y, deepest * (p.z - 1)};
}

inline insitu_frame geodetic() {
  insitu_frame frame = insitu_frame_default();
  frame.kind = INSITU_FRAME_GEODETIC;
  return frame;
}

/// A sea from 10 to 20 E, 30 to 40 N, 4 km deep.
inline TestMesh sea(Shape shape) {
  TestMesh mesh = box_cells(cells_along, shape, 0);
  for (Vec3d& p : mesh.vertices)
    p = on_earth(p);
  return mesh;
}

/// Its frames, cycle by cycle.
struct SeaRun {
  explicit SeaRun(const std::string& items, Shape shape = Shape::wedge)
      : mesh(sea(shape)), folder(std::filesystem::temp_directory_path() /
                                 ("insitu-geocentric-" + std::to_string(::getpid()))),
        context(0, mesh.committed.log),
        runner(scene::parse_scene_text("insitu: 1\n" + items, "s.yaml"), folder.string(), context,
               world, statistics) {
    mesh.committed.mesh.reference_frame = geodetic();
    mesh.field("height", INSITU_VERTEX, [](const Vec3d& p) { return p.z; });
    mesh.committed.commit(INSITU_CHANGED_ALL);
  }
  ~SeaRun() { std::filesystem::remove_all(folder); }

  std::string execute(std::int64_t cycle) { return runner.execute(meshes, cycle, double(cycle)); }
  std::int64_t bytes() const { return context.memory.current(INSITU_MEMORY_GEOCENTRIC); }

  RenderMesh mesh;
  std::filesystem::path folder;
  core::Context context;
  parallel::SerialWorld world;
  scene::Statistics statistics;
  scene::Runner runner;
  commit::CommittedMesh* list[1] = {&mesh.committed.mesh};
  scene::MeshList meshes{list};
};

/// How far along the ray WGS84 is first met.
inline double distance_to_ellipsoid(const render::Ray& ray) {
  const double a = 6378137.0, b = a * (1 - 1 / 298.257223563);
  const Vec3d o{ray.origin.x / a, ray.origin.y / a, ray.origin.z / b};
  const Vec3d d{ray.direction.x / a, ray.direction.y / a, ray.direction.z / b};
  const double dd = dot(d, d), od = dot(o, d), oo = dot(o, o) - 1;
  const double root = od * od - dd * oo;
  return root < 0 ? HUGE_VAL : (-od - std::sqrt(root)) / dd;
}

inline render::FrameSettings view_from(double longitude, double latitude, double height, int size) {
  render::FrameSettings s;
  s.width = s.height = size;
  s.depth = s.cell = true;
  s.camera.position = geocentric_place(longitude, latitude, height);
  const scene::LocalAxes axes = scene::local_axes(longitude, latitude);
  s.camera.look_at = s.camera.position - 1e6 * axes.up;
  s.camera.up = axes.north;
  return s;
}

struct Drawn {
  Drawn(SeaRun& run, double exaggeration)
      : structures(run.context),
        mesh(structures.geocentric(run.mesh.committed.mesh, exaggeration)) {}
  render::FrameImages draw(const render::FrameSettings& settings, core::Context& context) const {
    return render::render_frame(mesh.sampler(), settings, context.threads, context.memory);
  }
  scene::FrameStructures structures;
  const commit::CommittedMesh& mesh;
};

constexpr const char* boundary = "frames: [{name: f, size: [16, 16], geocentric: {exaggeration: "
                                 "100}, boundary: {color: {field: height}}}]";

} // namespace insitu::test

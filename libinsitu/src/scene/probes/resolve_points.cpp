#include "scene/probes/resolve_points.h"

#include "core/status.h"
#include "geo/geodesic.h"
#include "scene/earth/reference_frames.h"
#include "scene/probes/points.h"
#include "scene/probes/points_file.h"

namespace insitu::scene {

namespace {

/// What has no meaning in the frame is refused with the frame's line.
[[noreturn]] void refuse(const FrameOfReference& frame, const std::string& scene_file,
                         const std::string& what) {
  throw core::Error(INSITU_ERROR_SCENE,
                    scene_file + (frame.line > 0 ? ":" + std::to_string(frame.line) : "") + ": " +
                        what);
}

CurtainPlaces resolve_curtain(const Curtain& curtain, const insitu_frame& frame) {
  CurtainPlaces out;
  out.frame = frame;
  out.levels = curtain.levels;
  if (frame.kind == INSITU_FRAME_GEODETIC) {
    const geo::Frame units = to_geo(frame); // a mesh's own may be radians
    geo::Frame degrees = units;
    degrees.radians = false;
    geo::Path path =
        geo::geodesic_path(geo::convert(units, degrees, curtain.through), curtain.count);
    out.stations = geo::convert(degrees, units, path.places);
    out.distances = std::move(path.distances);
    return out;
  }
  const auto levels = std::int64_t(curtain.levels.size());
  for (std::int64_t i = 0; i < curtain.count; ++i) {
    out.stations.push_back(point_at(curtain, i * levels));
    out.stations.back().z = 0;
    out.distances.push_back(distance_at(curtain, i));
  }
  return out;
}

} // namespace

std::string read_points_for_all(const PointSource& source, parallel::World& world) {
  const auto* const file = std::get_if<PointFile>(&source);
  if (!file)
    return {};
  std::string text;
  world.agree_after([&] {
    if (world.is_root())
      text = read_points_text(file->path);
  });
  return world.broadcast(text);
}

ScenePoints resolve_points(const PointSource& source, const FrameOfReference& frame,
                           const commit::CommittedMesh& mesh, const std::string& scene_file,
                           const std::string* text) {
  ScenePoints out;
  FrameOfReference used = frame;
  const insitu_frame_kind kind = to_api(used, mesh.reference_frame).kind;
  if (std::holds_alternative<Sphere>(source) && kind == INSITU_FRAME_GEODETIC)
    refuse(used, scene_file,
           "a sphere has no meaning in longitude and latitude, which the mesh is in; give it in "
           "another frame");
  if (std::holds_alternative<Curtain>(source) && kind == INSITU_FRAME_GEOCENTRIC)
    refuse(used, scene_file,
           "a curtain has no upright in geocentric coordinates, which the mesh is in; give it in "
           "another frame");
  if (const auto* file = std::get_if<PointFile>(&source)) {
    PointTable table = text ? parse_points_text(*text, file->path) : read_points_file(file->path);
    used = frame_of(table, frame, scene_file);
    out.mesh_points = std::move(table.points);
    out.names = std::move(table.names);
  } else if (const auto* transect = std::get_if<Transect>(&source);
             transect && to_api(used, mesh.reference_frame).kind == INSITU_FRAME_GEODETIC) {
    math::Vec3d ends[] = {transect->from, transect->to};
    const geo::Frame units =
        to_geo(to_api(used, mesh.reference_frame)); // the mesh's may be radians
    geo::Frame degrees = units;
    degrees.radians = false;
    geo::convert(units, degrees, ends, ends);
    out.mesh_points = geo::geodesic(ends[0], ends[1], transect->count);
    geo::convert(degrees, units, out.mesh_points, out.mesh_points);
  } else if (const auto* curtain = std::get_if<Curtain>(&source)) {
    out.curtain = resolve_curtain(*curtain, to_api(used, mesh.reference_frame));
    for (math::Vec3d at : out.curtain->stations)
      for (const double level : out.curtain->levels) {
        at.z = level;
        out.mesh_points.push_back(at);
      }
  } else {
    const std::int64_t n = point_count(source);
    out.mesh_points.reserve(std::size_t(n));
    for (std::int64_t i = 0; i < n; ++i)
      out.mesh_points.push_back(point_at(source, i));
  }
  try {
    convert_points(out.mesh_points, to_api(used, mesh.reference_frame), mesh.reference_frame);
  } catch (const core::Error& e) {
    throw core::Error(
        e.status(),
        (used.line > 0 ? scene_file + ":" + std::to_string(used.line) + ": " : std::string()) +
            e.what());
  }
  mesh.to_plane(out.mesh_points);
  return out;
}

} // namespace insitu::scene

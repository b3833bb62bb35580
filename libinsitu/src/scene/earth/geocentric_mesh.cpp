#include "scene/earth/geocentric_mesh.h"

#include <cstdio>

#include "core/status.h"
#include "geo/reference_frames.h"
#include "scene/earth/reference_frames.h"

namespace insitu::scene {

namespace {

/// Heights below this are refused: the vertical lines there come close to meeting.
constexpr double lowest = -6.0e6;

std::string text(double number) {
  char out[32];
  std::snprintf(out, sizeof out, "%g", number);
  return out;
}

} // namespace

GeocentricMesh::GeocentricMesh(const std::string& name, double exaggeration, core::Memory& memory)
    : exaggeration_(exaggeration), points_(memory, INSITU_MEMORY_GEOCENTRIC),
      shared_(name, memory) {}

void GeocentricMesh::check(const commit::CommittedMesh& own) {
  const std::string name = "mesh '" + own.mesh().name() + "'";
  if (own.reference_frame.kind == INSITU_FRAME_CARTESIAN)
    throw core::Error(INSITU_ERROR_SCENE, "geocentric: " + name +
                                              " has Cartesian coordinates, which have no place on "
                                              "Earth; insitu_mesh_frame gives it one");
  if (own.mesh().is_adaptive())
    throw core::Error(INSITU_ERROR_UNSUPPORTED, "geocentric: " + name + " is adaptive");
}

commit::CommittedMesh& GeocentricMesh::update(const commit::CommittedMesh& own,
                                              core::Context& context) {
  own.require_committed();
  check(own);
  return shared_.update(own, context, [&] {
    convert(own, context);
    return points_.data();
  });
}

void GeocentricMesh::convert(const commit::CommittedMesh& own, core::Context& context) {
  const mesh::MeshView& view = own.mesh().own_view();
  insitu_frame geodetic = insitu_frame_default();
  geodetic.kind = INSITU_FRAME_GEODETIC;
  const std::int32_t pieces = view.piece_count - view.halo_piece_count;
  points_.resize_discard(std::size_t(view.first_vertex[pieces]));
  for (std::int32_t p = 0; p < pieces; ++p) {
    const mesh::PieceView& piece = view.pieces[p];
    const std::int64_t first = view.first_vertex[p];
    constexpr std::int64_t grain = 1 << 13;
    context.threads.parallel_for(
        view.first_vertex[p + 1] - first, grain, [&](std::int64_t begin, std::int64_t end) {
          const std::span<math::Vec3d> points{points_.data() + first + begin,
                                              std::size_t(end - begin)};
          for (std::int64_t v = begin; v < end; ++v)
            points[std::size_t(v - begin)] = piece.point(v);
          convert_points(points, own.reference_frame, geodetic);
          for (math::Vec3d& point : points) {
            point.z *= exaggeration_;
            if (point.z < lowest)
              throw core::Error(INSITU_ERROR_SCENE,
                                "geocentric: an exaggeration of " + text(exaggeration_) +
                                    " takes a vertex of mesh '" + own.mesh().name() +
                                    "' at height " + text(point.z / exaggeration_) + " m to " +
                                    text(point.z) + " m, near the Earth's centre");
          }
          geo::to_geocentric(geo::Frame::geodetic(), points, points);
        });
  }
  ++conversions_;
}

} // namespace insitu::scene

/// Queries of the nearest vertices.
#include <algorithm>
#include <cmath>
#include <limits>

#include "api/query_args.h"
#include "api/session.h"
#include "commit/halo/everywhere.h"
#include "commit/nearest.h"
#include "core/caller_struct.h"
#include "core/timer.h"

namespace insitu::api {

using core::Error;

namespace {

/// Writes the vertices near a point where the caller wants them.
void put_vertices(std::size_t item, std::span<const query::NearVertex> found,
                  const insitu_vertices_args& args) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const auto room = std::size_t(args.nearest);
  const auto put = [&](auto* to, auto none, auto&& value) {
    for (std::size_t k = 0; to && k < room; ++k)
      to[item * room + k] = k < found.size() ? value(found[k]) : none;
  };
  using Vertex = const query::NearVertex&;
  put(args.vertices, std::int64_t(args.vertex_base - 1),
      [&](Vertex v) { return v.vertex + args.vertex_base; });
  put(args.pieces, std::int32_t(-1), [](Vertex v) { return v.piece; });
  put(args.ranks, std::int32_t(-1), [](Vertex v) { return v.rank; });
  put(args.global_vertices, std::int64_t(-1), [](Vertex v) { return v.global; });
  put(args.distances, nan, [](Vertex v) { return std::sqrt(v.squared); });
  for (std::size_t k = 0; args.places && k < room; ++k)
    for (int c = 0; c < 3; ++c)
      args.places[3 * (item * room + k) + std::size_t(c)] = k < found.size() ? found[k].x[c] : nan;
}

/// Throws core::Error.
void require_vertices_args(const insitu_vertices_args& args, const QueryPoints& points,
                           const mesh::Mesh& mesh) {
  const auto require_one_of = [](int value, int a, int b, const char* name) {
    if (value != a && value != b)
      throw Error(INSITU_ERROR_ARGUMENT, std::string(name) + ": " + std::to_string(value) + ", " +
                                             std::to_string(a) + " or " + std::to_string(b) +
                                             " expected");
  };
  require_one_of(args.vertex_base, 0, 1, "vertex_base");
  if (args.nearest < 1)
    throw Error(INSITU_ERROR_ARGUMENT,
                "nearest: " + std::to_string(args.nearest) + " vertices, at least 1 expected");
  require_distance(args.greatest_distance);
  const std::int64_t n = points.count() * args.nearest;
  QueryOutputs outputs(insitu_locate_args_default(), 0);
  outputs.add(args.vertices, n * 8, "vertices");
  outputs.add(args.pieces, n * 4, "pieces");
  outputs.add(args.ranks, n * 4, "ranks");
  outputs.add(args.global_vertices, n * 8, "global_vertices");
  outputs.add(args.distances, n * 8, "distances");
  outputs.add(args.places, n * 24, "places");
  outputs.refuse_overlaps(points, mesh, {});
}

} // namespace

void Session::nearest_vertices(SessionMesh& to, const insitu_vertices_args& given) {
  const core::Timer timer;
  const insitu_vertices_args args = core::from_caller(&given, "args");
  const bool everywhere = args.scope == INSITU_SCOPE_EVERYWHERE;
  parallel::World& world = processes_.world();
  if (everywhere) {
    world.check_usable();
    if (checked_)
      processes_.wait_for_all("a query everywhere");
  }
  std::vector<math::Vec3d> points;
  const auto take_arguments = [&] {
    const commit::CommittedMesh& mesh = committed(to);
    insitu_locate_args as_locate = insitu_locate_args_default();
    as_locate.points = args.points;
    as_locate.point_arrays = args.point_arrays;
    as_locate.frame = args.frame;
    as_locate.scope = args.scope;
    const QueryPoints query(as_locate);
    require_vertices_args(args, query, mesh.mesh());
    commit::require_nearest_vertices(mesh);
    points = points_of(mesh, as_locate, query);
  };
  const auto most = std::size_t(std::max(args.nearest, 0));
  const double farthest = farthest_of(args.greatest_distance);
  const auto put = [&](std::size_t i, const std::vector<query::NearVertex>& found) {
    put_vertices(i, found, args);
  };
  if (!everywhere) {
    take_arguments();
    const commit::CommittedMesh& mesh = answering(to);
    mesh.to_plane(points);
    commit::nearest_vertices(
        mesh, points, most, farthest, world.rank(), context_.threads,
        [&](std::size_t i, const query::NearVertices& found) { put(i, found.found()); });
  } else {
    world.agree_after(take_arguments);
    commit::CommittedMesh& mesh = answering(to);
    world.require_same([&] {
      return std::vector<parallel::Named>{
          {"mesh", mesh.mesh().name()},
          {"nearest", std::to_string(args.nearest)},
          {"greatest_distance", std::to_string(args.greatest_distance)}};
    });
    mesh.update_chart(world, context_.threads, context_.log);
    mesh.to_plane(points);
    commit::Everywhere(mesh, world).nearest_vertices(points, most, farthest, context_.threads, put);
  }
  statistics_.query_s += timer.seconds();
}

} // namespace insitu::api

#include "commit/nearest.h"

#include <cmath>

namespace insitu::commit {

using math::Vec3d;

NearestOwn own_of(const CommittedMesh& mesh, const query::NearestCell& found) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  if (!found.at)
    return {{}, {nan, nan, nan}, nan};
  const StandIn* const stand_in = mesh.stand_in();
  const query::ChartImage* const chart = stand_in ? stand_in->chart() : nullptr;
  Vec3d place = chart ? chart->point_of(found.point) : found.point;
  mesh.to_plane({&place, 1});
  query::Location own = mesh.own(found.at, place);
  if (!own) { // between the boundary of what the solver has and its rounding
    mesh::CellVertices cell;
    mesh::gather(mesh.mesh().view(), found.at.cell, cell);
    Vec3d middle;
    for (int v = 0; v < cell.count; ++v)
      middle += (1.0 / cell.count) * cell.x[v];
    own = mesh.own(found.at, place + 1e-9 * (middle - place));
  }
  if (mesh.is_flat())
    own.parametric.z = 0.5;
  return {own, place, std::sqrt(found.squared)};
}

void require_nearest(const CommittedMesh& mesh) {
  if (mesh.lies_on_device())
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      "mesh '" + mesh.mesh().name() +
                          "' lies in device memory; what is nearest is found on the host");
}

void require_nearest_vertices(const CommittedMesh& mesh) {
  require_nearest(mesh);
  if (mesh.mesh().is_adaptive())
    throw core::Error(INSITU_ERROR_ORDER, "mesh '" + mesh.mesh().name() +
                                              "' is adaptive: its vertices have no ids; "
                                              "insitu_outside asks for the nearest cell");
}

void nearest_vertices(
    const CommittedMesh& mesh, std::span<const Vec3d> places, std::size_t most, double farthest,
    int rank, const core::Threads& threads,
    core::FunctionRef<void(std::size_t i, const query::NearVertices& found)> visit) {
  const auto own_cell = [&](std::int64_t flat) {
    return mesh.stand_in() ? mesh.stand_in()->place(flat).own : flat;
  };
  const auto global_id = [&](std::int64_t vertex) {
    const std::int64_t id = mesh.mesh().global_id(INSITU_VERTEX, vertex);
    return mesh.mesh().is_flat() && id >= 0 ? id / 2 : id; // below and above the plane
  };
  const query::NearestVertices nearest(mesh.own_sampler(), mesh.mesh().own_view(), own_cell,
                                       global_id, rank);
  threads.parallel_for(std::int64_t(places.size()), 16, [&](std::int64_t begin, std::int64_t end) {
    for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
      query::NearVertices found(most, farthest);
      nearest.find(places[i], found);
      visit(i, found);
    }
  });
}

} // namespace insitu::commit

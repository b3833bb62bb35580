#pragma once

#include "commit/committed_mesh.h"
#include "query/nearest/nearest_cells.h"
#include "query/nearest/nearest_vertices.h"

/// What is nearest to a place, as the solver counts cells and vertices.
namespace insitu::commit {

struct NearestOwn {
  query::Location at; ///< flat over the pieces of own_view(); outside: no cell is near enough
  math::Vec3d place;  ///< the nearest point, in the mesh's frame
  double distance;
};
/// found: of the mesh's own_sampler().
NearestOwn own_of(const CommittedMesh& mesh, const query::NearestCell& found);

/// Throws INSITU_ERROR_UNSUPPORTED where the mesh lies on a device.
void require_nearest(const CommittedMesh& mesh);
/// The same of vertices; INSITU_ERROR_ORDER: those of an adaptive mesh are not the solver's.
void require_nearest_vertices(const CommittedMesh& mesh);

/// The vertices of this process that are nearest to each place: visit(i, found).
void nearest_vertices(
    const CommittedMesh& mesh, std::span<const math::Vec3d> places, std::size_t most,
    double farthest, int rank, const core::Threads& threads,
    core::FunctionRef<void(std::size_t i, const query::NearVertices& found)> visit);

} // namespace insitu::commit

#pragma once

#include <optional>
#include <span>

#include "commit/committed_mesh.h"
#include "parallel/world.h"
#include "render/frame.h"
#include "render/structures/vertex_cells.h"

/// What frames do with copies of cells on a chart (commit::StandIn).
namespace insitu::scene {

/// Whether cells of the mesh are located in copies on a chart, on this process.
bool has_chart_copies(const commit::CommittedMesh& mesh);

/// Of such a mesh, as its views are now.
render::ChartCopies find_chart_copies(const commit::CommittedMesh& mesh,
                                      const core::Threads& threads);

/// Where the chart begins that meshes in longitude and latitude are drawn on together, of the whole
/// meshes: as far west as that of any; an empty optional: none of them has a chart.
std::optional<double> first_west(std::span<const commit::CommittedMesh* const> meshes);

/// Whether one of several meshes of a frame, those of one process, is drawn in copies that begin
/// there.
bool begins_further_east(std::span<const commit::CommittedMesh* const> meshes, std::size_t mesh);

/// Ends what a frame draws at the chart's ends, which are those of the box around all meshes:
/// copies reach over them, where their places are shown already, and others lie beyond on charts
/// turned to a pole. Faces that lie in the ends are seen.
void end_at_chart(const mesh::Box& all, render::FrameSettings& settings);

/// Gives numbers at this process's vertices to the other processes that have copies of its cells,
/// as Halo::refresh_values() does. values: [flat vertex of mesh().view()], alike at all copies of a
/// vertex. Collective, of a mesh with a halo; throws parallel::AgreedError.
void refresh_vertex_values(const commit::CommittedMesh& mesh, parallel::World& world,
                           std::span<double> values);

} // namespace insitu::scene

#pragma once

#include <span>
#include <vector>

#include "advect/across/lines_across.h"
#include "parallel/world.h"
#include "scene/run/own_cell.h"
#include "scene/tracers/tracer_action.h"

namespace insitu::scene {

/// The streamlines of all processes at the root, as trace_streamlines() gives those of one process,
/// with the values of fields at their vertices, found where these are; nothing on other processes.
struct GatheredLines {
  /// Collective; throws parallel::AgreedError. here: this process's; per_seed: lines of a seed.
  GatheredLines(const advect::LinePieces& here, const TracerAction& tracer,
                const commit::CommittedMesh& mesh, std::span<const mesh::FieldView> fields,
                parallel::World& world, core::Memory& memory, std::int64_t per_seed);

  advect::Polylines lines;    ///< without cells
  std::vector<OwnCell> cells; ///< [vertex]
  std::vector<double> values; ///< [vertex][column]
};

} // namespace insitu::scene

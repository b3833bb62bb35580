#pragma once

#include <optional>
#include <string>
#include <vector>

#include "commit/committed_mesh.h"
#include "parallel/world.h"
#include "scene/probes/attached_points.h"
#include "scene/run/own_cell.h"

namespace insitu::scene {

/// What a probe found, row by row.
struct ProbeAnswers {
  std::vector<OwnCell> cells;          ///< [point]
  std::vector<math::Vec3d> parametric; ///< [point] coordinates in the cell, if there is one
  std::vector<std::string> columns;    ///< of the values
  std::vector<double> values;          ///< [point][column], NaN outside; last the distance to the
                                       ///< cell, if nearest cells are asked for

  bool found(std::size_t point) const { return cells[point].flat >= 0; }
};

/// What is asked of a mesh.
struct ProbeQuestion {
  const commit::CommittedMesh& mesh;
  const std::vector<mesh::FieldView>& fields; ///< of find_fields()
  const query::LocateOptions& options;
  bool by_ids;                    ///< all processes have global ids of cells
  const AttachedPoints* attached; ///< has the points' places, or null: they are located
  std::optional<double> farthest = std::nullopt; ///< if points outside get the nearest cell
};

/// Answers a probe's points by the cells of all processes: each answers what its own cells hold, a
/// slice of the points at a time, and the root keeps of each point the answer of the lowest cell:
/// by global ids, or of the lowest process. Returns all answers at the root, and at other processes
/// the columns alone. Points that no cell of all processes holds get the nearest one, if the
/// question says so. points: the same on all processes; of attached ones as their owners know them,
/// which the root is told. slice: of how many points. Collective. Throws parallel::AgreedError.
ProbeAnswers answer_points(const ProbeQuestion& question, std::vector<math::Vec3d>& points,
                           parallel::World& world, const core::Threads& threads,
                           std::size_t slice = std::size_t(1) << 20);

} // namespace insitu::scene

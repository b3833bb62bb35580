#pragma once

#include <cstdint>

#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::commit {

/// Vertices of cells that own points which touch such a cell without being one of its corners: the
/// two do not fit each other. By place, so ids do not matter.
struct HangingVertices {
  std::int64_t hanging = 0; ///< on a face or edge of a cell, to 1e-9 of the cell
  std::int64_t covered = 0; ///< in the interior of a cell: cells overlap
};

/// Looks at every such vertex, by a tree of its own, which costs a build, in a few times the time
/// of locating them; longer where many cells lie in one place. The mesh must be valid
/// (cells/checks/validate.h). Throws core::Error(INSITU_ERROR_MESH) if no float can hold a cell's
/// box.
HangingVertices find_hanging_vertices(const mesh::MeshView& mesh, const core::Threads& threads);

} // namespace insitu::commit

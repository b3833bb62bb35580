#pragma once

#include <string>

#include "mesh/view.h"

namespace insitu::cells {

/// What is lost where coordinates of 32 bits lie far from the origin, in words: more than a
/// thousandth of a cell's extent along some axis, the median of up to 1024 cells of a piece. Empty
/// where there is nothing to say. The ids and coordinates of cells that are no ghosts must be
/// sound.
std::string float_rounding(const std::string& mesh_name, const mesh::MeshView& view);

} // namespace insitu::cells

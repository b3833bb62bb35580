#pragma once

#include <vector>

#include "advect/field/homes.h"
#include "core/parallel.h"
#include "mesh/box.h"
#include "mesh/view.h"

namespace insitu::advect {

/// Some boxes that hold all cells that this process owns, between the earlier and the current step:
/// at most query::Directory::most_boxes of them, each of cells whose numbers follow each other.
std::vector<mesh::Box> own_boxes(const mesh::MeshView& mesh, const Homes& homes,
                                 const core::Threads& threads);

} // namespace insitu::advect

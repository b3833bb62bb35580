#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "accel/tree/tree.h"
#include "mesh/box.h"
#include "mesh/view.h"

namespace insitu::commit {

/// The own cells of a view whose leaves in its tree, which is fitted, meet one of the boxes of its
/// coordinates, ascending: all that meet them, and a few more.
std::vector<std::int64_t> cells_near(const mesh::MeshView& view, const accel::Tree& tree,
                                     std::span<const mesh::Box> boxes);

} // namespace insitu::commit

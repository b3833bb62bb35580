#pragma once

#include <cstdint>

#include "mesh/view.h"

namespace insitu::mesh {

/// Copies the items [begin, end) of an array with so many components, as doubles, to
/// [item - begin][component]: the values that load() gives, to the bit. Items that lie side by side
/// go as memory does, and sections row by row.
void copy_items(const FieldPieceView& from, int components, std::int64_t begin, std::int64_t end,
                double* to);

/// The same of a piece's coordinates, [vertex - begin][axis].
void copy_points(const PieceView& from, std::int64_t begin, std::int64_t end, math::Vec3d* to);

} // namespace insitu::mesh

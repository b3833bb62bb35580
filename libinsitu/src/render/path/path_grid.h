#pragma once

#include "render/volume/whole_grid.h"

namespace insitu::render {

constexpr double most_path_macrocells = 0x1p14;

/// The grid of majorants of a mesh with these facts and widths: about cells_each cells to a
/// macrocell, which has the proportions of a mean cell, and most_path_macrocells at most. Throws
/// core::Error (INSITU_ERROR_ARGUMENT) unless cells_each is above 0.
inline MacrocellGrid path_grid(const mesh::MeshFacts& whole, const CellWidths& widths,
                               double cells_each) {
  return whole_grid(whole, widths, {cells_each, most_path_macrocells});
}

} // namespace insitu::render

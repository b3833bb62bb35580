#pragma once

#include <array>
#include <cstdint>

#include "mesh/facts.h"
#include "query/sampler.h"
#include "render/volume/macrocells.h"

namespace insitu::render {

/// How wide a mesh's cells are: for each set of axes (a bit an axis) the sum over all owning cells
/// of the products of their widths along these, each in widths of the mesh and rounded to units of
/// 2^-30; for no axis, so many units a cell. Of parts of a mesh they add up in any order to the
/// same numbers, of fewer than 2^33 cells.
using CellWidths = std::array<std::int64_t, 8>;

/// Of the sampler's own cells, in a mesh that fills the box. One pass over the cells.
CellWidths cell_widths(const query::Sampler& sampler, const mesh::Box& whole,
                       const core::Threads& threads);

/// The grid of macrocells of a mesh with these facts and widths: the same however the mesh is
/// numbered, or spread over processes. Throws core::Error (INSITU_ERROR_ARGUMENT) for macrocells of
/// no cells.
MacrocellGrid whole_grid(const mesh::MeshFacts& whole, const CellWidths& widths,
                         const MacrocellFineness& fineness);

/// That on which a volume's tolerance chooses steps.
inline MacrocellGrid level_grid(const mesh::MeshFacts& whole, const CellWidths& widths) {
  constexpr double most_macrocells = 0x1p18;
  return whole_grid(whole, widths, {MacrocellFineness::usual_cells, most_macrocells});
}

} // namespace insitu::render

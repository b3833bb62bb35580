#pragma once

#include "query/sampler.h"

namespace insitu::render {

/// The median, over up to 4096 cells evenly picked by id, of the cube root of the cell's bounding
/// box's volume; at least 1/16384 of the mesh's diagonal, and 1/256 of it for cells without volume.
double typical_cell_size(const query::Sampler& sampler);

/// Of the mesh's box; 1 where that has none.
double mesh_diagonal(const query::Sampler& sampler);

} // namespace insitu::render

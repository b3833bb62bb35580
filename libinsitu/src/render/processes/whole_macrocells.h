#pragma once

#include "parallel/world.h"
#include "render/structures/structures.h"

namespace insitu::render {

/// Of the cells of all processes; the sampler's facts() are those of the whole mesh. Collective;
/// throws AgreedError.
CellWidths whole_widths(parallel::World& world, const query::Sampler& sampler,
                        Structures& structures);

/// What macrocells on a grid have of the cells of all processes: one reduction, of 24 bytes a
/// macrocell, or 32 with cells' sizes. Collective; throws AgreedError.
Macrocells whole_macrocells(parallel::World& world, const query::Sampler& sampler,
                            const ScalarField& field, const MacrocellGrid& grid, bool with_sizes,
                            Structures& structures);

} // namespace insitu::render

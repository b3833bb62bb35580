#pragma once

#include "mesh/box.h"
#include "query/sampler.h"

namespace insitu::render {

/// mesh::MeshFacts::cell_size() of the mesh.
double typical_cell_size(const query::Sampler& sampler);

/// mesh::MeshFacts::diagonal() of the mesh.
double mesh_diagonal(const query::Sampler& sampler);

/// The tree's box, in which all cells are; on a chart the part within its ends.
mesh::Box outer_bounds(const query::Sampler& sampler);

} // namespace insitu::render

#pragma once

#include "query/sampler.h"

namespace insitu::render {

/// mesh::MeshFacts::cell_size() of the mesh.
double typical_cell_size(const query::Sampler& sampler);

/// mesh::MeshFacts::diagonal() of the mesh.
double mesh_diagonal(const query::Sampler& sampler);

} // namespace insitu::render

#pragma once

#include "mesh/facts.h"
#include "parallel/world.h"

namespace insitu::render {

/// The facts of a mesh that is spread over processes, from those of its parts. Collective.
mesh::MeshFacts whole_facts(parallel::World& world, const mesh::MeshFacts& mine);

} // namespace insitu::render

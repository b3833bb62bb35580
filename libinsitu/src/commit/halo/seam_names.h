#pragma once

#include <string>

#include "commit/halo/cell_pairs.h"

namespace insitu::commit {

class CommittedMesh;

/// Collective, of a mesh that has a halo: what is wrong with global ids, as sentences without the
/// mesh, one behind the other; empty if nothing. Cells of two processes that touch may have one id,
/// as where a process gives its own numbers; or some processes give ids and others none. Then the
/// owner of a point on a seam hangs on how cells are spread.
std::string describe_wrong_ids(const CommittedMesh& mesh, parallel::World& world);

} // namespace insitu::commit

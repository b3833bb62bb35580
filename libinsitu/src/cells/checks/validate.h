#pragma once

#include <string>

#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::cells {

/// A mesh's arrays as they are, looked at.
struct Validation {
  insitu_validation counts;
  std::string findings; ///< the first errors, one a line; empty if the mesh is accepted
  std::string warning;  ///< one line that counts what is odd; empty if nothing is
};

/// Looks at every cell and every vertex that a cell uses, for folds anywhere in it. Reads no
/// coordinate through an id that is out of range. The same report for any thread count. Faces are
/// not matched (cells/checks/conformity.h). first: of the pieces that are looked at.
Validation validate(const std::string& mesh_name, const mesh::MeshView& mesh,
                    const core::Threads& threads, std::int32_t first = 0);

/// Adds what was counted of other pieces.
void join(insitu_validation& to, const insitu_validation& from);

} // namespace insitu::cells

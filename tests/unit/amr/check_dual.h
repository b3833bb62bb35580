// What holds for every dual mesh, against plain loops over all of its cells.
#pragma once

#include <string>

#include "amr/dual/dual_mesh.h"
#include "amr_mesh.h"

namespace insitu::test {

struct DualFacts {
  std::string problem; ///< the first one; empty: none
  std::int64_t cells = 0, unmatched = 0;
  double volume = 0.0;   ///< of all cells
  double enclosed = 0.0; ///< by unmatched faces
  double leaves = 0.0;   ///< volume of the leaves
};

struct Expect {
  bool covers_leaves = true; ///< all of the domain
  bool conforming = true;    ///< unmatched faces lie on the domain's boundary
  bool no_folds = true;
  bool linear =
      true; ///< virtual leaves meet linear fields: their leaves have neighbours all around
  bool ghosts = false; ///< linear fields are met on the boundary, too
};

DualFacts check_dual(AmrMesh& mesh, const amr::DualMesh& dual, const Expect& expect);

} // namespace insitu::test

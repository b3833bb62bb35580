#pragma once

#include <cstdint>
#include <string>

#include "commit/halo/cell_pairs.h"
#include "commit/halo/halo.h"

namespace insitu::commit {

/// Faces of two processes that should be one: they lie within the mesh's seam_tolerance of each
/// other, and do not match to the bit. Between them points have no owner, or two. On a mesh in
/// longitude and latitude they match if they are whole turns apart, and distances are in metres.
/// The pairs are of faces.
struct SeamMismatches : CellPairs {
  static constexpr double most_tolerance = 0.1;
  double tolerance = 0.0; ///< in the diameter of a face
  CellPairs twice;        ///< cells that are the same to the bit, and no ghosts
};

/// Of a mesh that has a halo, whose views hold it. Linear in the cells at seams.
SeamMismatches find_seam_mismatches(const CommittedMesh& mesh);

/// Collective: what all processes found, as describe() of pairs.
std::string describe(const SeamMismatches& found, parallel::World& world);
std::string describe_twice(const SeamMismatches& found, parallel::World& world);
/// Of an adaptive mesh, LeafSearch::gaps.
std::string describe_gaps(const CellPairs& found, parallel::World& world);

} // namespace insitu::commit

#pragma once

#include <cstdint>
#include <string>

#include "commit/halo/halo.h"

namespace insitu::commit {

/// Faces of two processes that should be one: they lie within the mesh's seam_tolerance of each
/// other, and do not match to the bit. Between them points have no owner, or two. On a mesh in
/// longitude and latitude they match if they are whole turns apart, and distances are in metres.
struct SeamMismatches {
  static constexpr double most_tolerance = 0.1;
  double tolerance = 0.0; ///< in the diameter of a face
  std::int64_t count = 0; ///< of this process's faces
  CellName own, other;    ///< the cells of the first pair, if there is one
};

/// Of a mesh that has a halo, whose views hold it. Linear in the cells at seams.
SeamMismatches find_seam_mismatches(const CommittedMesh& mesh);

/// Collective: what all processes found, as a sentence without its mesh; empty if nothing. found:
/// by this process.
std::string describe(const SeamMismatches& found, parallel::World& world);
std::string describe(const LeafGaps& found, parallel::World& world);

} // namespace insitu::commit

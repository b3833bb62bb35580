#pragma once

#include <cstdint>
#include <vector>

#include "core/parallel.h"
#include "mesh/box.h"

namespace insitu::mesh {

/// What is asked of a mesh as a whole: where its cells end, and how large they are. It holds
/// extremes and counts alone, so facts of parts of a mesh add up in any order to the same bits.
struct MeshFacts {
  /// Cells whose boxes have about the same volume, within an eighth.
  struct SizeClass {
    std::uint32_t key;  ///< exponent and upper three bits of the volume
    std::int64_t cells; ///< at least 1
    double least;       ///< the smallest of their volumes
  };

  Box bounds{};                 ///< of the vertices of all these cells, exact; if there are any
  std::int64_t cells = 0;       ///< that own points, but for copies on charts turned to a pole
  std::vector<SizeClass> sizes; ///< by ascending key

  void add(const MeshFacts& other);
  /// The length of the bounds' diagonal; 1 if that is 0 or there are no cells.
  double diagonal() const;
  /// The size of most cells: the cube root of the smallest volume in the median's class, at least
  /// diagonal() / 16384; diagonal() / 256 where the median is flat, diagonal() without cells.
  double cell_size() const;
};

/// One pass over the cells. threads: null: on the calling thread alone.
MeshFacts find_facts(const MeshView& mesh, const core::Threads* threads);

} // namespace insitu::mesh

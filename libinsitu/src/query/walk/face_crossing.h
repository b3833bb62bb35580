#pragma once

#include <cstdint>
#include <optional>

#include "math/vec.h"
#include "query/sampler.h"

/// Where straight segments leave cells, and the mesh.
namespace insitu::query {

/// A point of a face of a cell where a segment a + t (b - a) goes out through it.
struct FaceCrossing {
  double t = 0.0;         ///< in [0, 1]
  math::Vec3d point;      ///< on the face to rounding, bilinear or plane; not always on the segment
  std::int64_t cell = -1; ///< flat id
  int face = -1;          ///< of cells::face_table(shape)
  math::Vec3d normal;     ///< of the face there, unit, out of the cell (0 if the face has no area)
};

/// The face that is nearest to parametric coordinates in or about the cell, its point there, and
/// its normal; t is 0.
FaceCrossing nearest_face(const mesh::CellVertices& vertices, std::int64_t cell,
                          const math::Vec3d& parametric);

/// Where a segment leaves the mesh: the face has a cell on this side and none beyond.
struct Exit : FaceCrossing {
  math::Vec3d inside; ///< the crossing's point, or one as near as doubles have that a cell owns
  std::int64_t owner = -1; ///< its owner
};

/// Where the segment from a, located in `cell`, first leaves the mesh; nothing if b is reached
/// without: always something if no cell owns b. It goes from cell to cell; where rounding stops
/// that, it bisects. The exit is placed to rounding of the coordinates. Where cells of the boundary
/// meet, the face is one beyond which nothing lies; should none be found (a point at which cells
/// merely touch), it is the last cell's. Costs a locate() and the faces of a cell, per cell passed.
std::optional<Exit> leave_mesh(const Sampler& sampler, std::int64_t cell, const math::Vec3d& a,
                               const math::Vec3d& b, const LocateOptions& options = {});

} // namespace insitu::query

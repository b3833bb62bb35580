#pragma once

#include <cstdint>
#include <vector>

#include "workload/mesh.h"

namespace insitu::bench::torture {

/// How a point was made.
enum class Place : std::uint8_t {
  inside,        ///< random parametric coordinates of a random cell
  face,          ///< on a face, as rounding leaves it
  edge,          ///< the same on an edge
  vertex,        ///< exactly a vertex
  beside_face,   ///< a face's, one component moved to the next double
  beside_edge,   ///< the same of an edge
  beside_vertex, ///< the same of a vertex
  level,         ///< each component that of a vertex of one cell
  around,        ///< anywhere in the mesh's box and a quarter beyond
};
constexpr int place_count = 9;
const char* name(Place place);

struct Point {
  math::Vec3d at;
  Place place;
  std::int32_t made_in = 0; ///< the cell it was made from
  /// Within the mesh's hull, were it conforming: made from something that is not on its outside.
  bool within = false;
};

/// `count` points, all places in turn.
std::vector<Point> make_points(const workload::Mesh& mesh, std::int64_t count);

} // namespace insitu::bench::torture

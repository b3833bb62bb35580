#pragma once

#include <cstdint>
#include <optional>
#include <string_view>
#include <vector>

#include "workload/mesh.h"

namespace insitu::workload {

enum class Pattern { uniform, random, sorted, march };

/// "uniform", "random", "sorted", "march".
const char* name(Pattern pattern);
std::optional<Pattern> pattern_from_name(std::string_view name);

struct Queries {
  std::vector<math::Vec3d> points;
  /// The cell that each point was made in; empty for marched points. A point near the cell's
  /// boundary may have been rounded across it.
  std::vector<std::int32_t> made_in;
};

/// Queries on a mesh.
///  - uniform: the vertex average of every cell, in cell order; `count` is ignored.
///  - random: `count` points, each in a random cell at random parametric coordinates.
///  - sorted: the same points in Morton order over the mesh's box (stable, 21 bits an axis).
///  - march: points half a cell apart along the view rays of the standard camera through the
///    mesh's box, from the image's middle row on, until there are `count` of them; fewer if the
///    image has fewer.
Queries make_queries(const Mesh& mesh, Pattern pattern, std::int64_t count);

/// The parametric point of random query i in a cell of that shape.
math::Vec3d random_parametric(mesh::Shape shape, std::uint64_t i);

enum class Feature { vertices = 3, edges = 4, faces = 5 };

/// `count` points on vertices, edges or faces of random cells, built in double: exactly a vertex,
/// or the blend of an edge's or face's vertices (so on edges and faces only up to rounding).
Queries make_boundary_queries(const Mesh& mesh, Feature feature, std::int64_t count);

} // namespace insitu::workload

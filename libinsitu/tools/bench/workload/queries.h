#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "workload/mesh.h"

namespace insitu::workload {

enum class Pattern { uniform, random, sorted, march, vertices, edges, faces };
constexpr bool is_boundary(Pattern p) {
  return p >= Pattern::vertices;
}

/// "uniform", "random", "sorted", "march", "vertices", "edges", "faces".
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
///  - random: `count` points, each in a random cell at random parametric coordinates; among
///    polyhedra anywhere where these leave no gaps, and made in no cell that is known.
///  - sorted: the same points in morton_order.
///  - march: points half a cell apart along the view rays of the standard camera through the
///    mesh's box, from the image's middle row on, until there are `count` of them; fewer if the
///    image has fewer.
///  - vertices, edges, faces: `count` points on those of random cells, built in double: exactly a
///    vertex, or the blend of an edge's or face's vertices (so on edges and faces only up to
///    rounding).
Queries make_queries(const Mesh& mesh, Pattern pattern, std::int64_t count);

/// The parametric point of random query i in a cell of that shape.
math::Vec3d random_parametric(mesh::Shape shape, std::uint64_t i);

/// The places of the points in Morton order over their box: stable, 11 bits an axis.
std::vector<std::uint32_t> morton_order(std::span<const math::Vec3d> points);

} // namespace insitu::workload

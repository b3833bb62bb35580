#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "node.h"

namespace insitu::blueprint {

/// A shape of Blueprint's.
struct ShapeName {
  const char* name;
  int dimensions;
  std::uint8_t vtk; ///< its number there
  int ids;          ///< 0: any number

  bool is_polygon() const { return vtk == 7; }
  bool is_polyhedron() const { return vtk == 42; }
};

/// Null if there is none of that name.
const ShapeName* shape_of(const std::string& name);
[[noreturn]] void refuse_shape(const Node& node, const std::string& name);

/// A shape of a map, by the number that the map gives it; null for one that is unknown, which a map
/// may name all the same.
struct Mapped {
  std::int64_t number;
  const ShapeName* shape;
  std::string name;
};
using Shapes = std::vector<Mapped>; ///< a handful

Shapes shapes_of(const Node& map);

/// The shape of a mixed cell. numbers: of the node shapes.
const ShapeName& shape_at(const Node& node, const Leaf& numbers, std::int64_t cell,
                          const Shapes& shapes);

} // namespace insitu::blueprint

#include "shapes.h"

namespace insitu::blueprint {

namespace {

constexpr ShapeName known_shapes[] = {
    {"point", 0, 1, 1},     {"line", 1, 3, 2},       {"tri", 2, 5, 3},  {"quad", 2, 9, 4},
    {"polygonal", 2, 7, 0}, {"tet", 3, 10, 4},       {"hex", 3, 12, 8}, {"wedge", 3, 13, 6},
    {"pyramid", 3, 14, 5},  {"polyhedral", 3, 42, 0}};

} // namespace

const ShapeName* shape_of(const std::string& name) {
  for (const ShapeName& s : known_shapes)
    if (name == s.name)
      return &s;
  return nullptr;
}

void refuse_shape(const Node& node, const std::string& name) {
  node.refuse(INSITU_ERROR_UNSUPPORTED,
              "is '" + name +
                  "'; tet, hex, wedge, pyramid, polyhedral and mixed are supported, and tri, quad "
                  "and polygonal in one plane");
}

Shapes shapes_of(const Node& map) {
  Shapes out;
  for (std::int64_t i = 0; i < map.size(); ++i) {
    const Node entry = map.child(i);
    const std::string name = entry.name();
    out.push_back({entry.integer(), shape_of(name), name});
  }
  return out;
}

const ShapeName& shape_at(const Node& node, const Leaf& numbers, std::int64_t cell,
                          const Shapes& shapes) {
  const std::int64_t number = numbers.integer(cell);
  for (const Mapped& m : shapes) {
    if (m.number != number)
      continue;
    if (!m.shape)
      refuse_shape(node, m.name);
    return *m.shape;
  }
  node.refuse(INSITU_ERROR_ARGUMENT, "of cell " + std::to_string(cell) + " is " +
                                         std::to_string(number) + ", which is not in shape_map");
}

int dimensions_of(const std::string& shape) {
  const ShapeName* known = shape_of(shape);
  return known ? known->dimensions : -1;
}

} // namespace insitu::blueprint

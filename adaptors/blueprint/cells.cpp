#include <algorithm>
#include <map>

#include "domain.h"

namespace insitu::blueprint {

namespace {

struct ShapeName {
  const char* name;
  int dimensions;
  std::uint8_t vtk; ///< its number there
  int ids;          ///< 0: any number
};

constexpr ShapeName shapes[] = {
    {"point", 0, 1, 1},     {"line", 1, 3, 2},       {"tri", 2, 5, 3},  {"quad", 2, 9, 4},
    {"polygonal", 2, 7, 0}, {"tet", 3, 10, 4},       {"hex", 3, 12, 8}, {"wedge", 3, 13, 6},
    {"pyramid", 3, 14, 5},  {"polyhedral", 3, 42, 0}};

const ShapeName* shape_of(const std::string& name) {
  for (const ShapeName& s : shapes)
    if (name == s.name)
      return &s;
  return nullptr;
}

[[noreturn]] void refuse_shape(const Node& node, const std::string& name) {
  node.refuse(INSITU_ERROR_UNSUPPORTED,
              "is '" + name + "'; tet, hex, wedge, pyramid and mixed are supported");
}

void read_one_shape(const Node& elements, Domain& d) {
  const Node shape_node = elements.at("shape");
  const ShapeName* shape = shape_of(shape_node.text());
  if (!shape || shape->dimensions != 3 || shape->ids == 0)
    refuse_shape(shape_node, shape_node.text());
  const Node connectivity = elements.at("connectivity");
  d.cells.layout = INSITU_LAYOUT_UNIFORM;
  d.cells.shape = static_cast<insitu_shape>(shape->vtk);
  insitu_array all = ids(connectivity, d.copies);
  if (all.count % shape->ids != 0)
    connectivity.refuse(INSITU_ERROR_ARGUMENT, "has " + std::to_string(all.count) +
                                                   " ids, which are not whole cells of " +
                                                   std::to_string(shape->ids));
  if (const Node offsets = elements.find("offsets")) {
    const Leaf leaf = offsets.leaf();
    for (std::int64_t c = 0; c < leaf.count; ++c)
      if (leaf.integer(c) != c * shape->ids)
        offsets.refuse(INSITU_ERROR_UNSUPPORTED, "of cell " + std::to_string(c) + " is " +
                                                     std::to_string(leaf.integer(c)) +
                                                     "; cells of one shape have to be packed");
  }
  all.count /= shape->ids;
  all.components = shape->ids;
  if (all.stride[0] != 0) {
    all.component_stride = all.stride[0];
    all.stride[0] *= shape->ids;
  }
  d.cells.connectivity = all;
  d.cells.count = d.cell_count = all.count;
}

/// The shapes of a map, by the number that it gives them.
std::map<std::int64_t, const ShapeName*> shapes_of(const Node& map) {
  std::map<std::int64_t, const ShapeName*> out;
  for (std::int64_t i = 0; i < map.size(); ++i) {
    const Node entry = map.child(i);
    const ShapeName* shape = shape_of(entry.name());
    if (!shape)
      refuse_shape(entry, entry.name());
    out[entry.integer()] = shape;
  }
  return out;
}

/// VTK's numbers of the cells' shapes, in place where they are these already.
void read_types(const Node& elements, Domain& d) {
  const Node node = elements.at("shapes");
  const Leaf leaf = node.leaf();
  if (!leaf.is_integer())
    node.refuse(INSITU_ERROR_ARGUMENT, "holds no integers");
  const auto map = shapes_of(elements.at("shape_map"));
  bool in_place = leaf.type == Conduit::uint8 && leaf.stride == 1;
  for (const auto& [number, shape] : map)
    in_place = in_place && number == shape->vtk && shape->dimensions == 3;
  std::uint8_t* types = d.copies.make<std::uint8_t>(leaf.count);
  std::map<std::string, std::int64_t> flat;
  for (std::int64_t c = 0; c < leaf.count; ++c) {
    const auto found = map.find(leaf.integer(c));
    if (found == map.end())
      node.refuse(INSITU_ERROR_ARGUMENT, "of cell " + std::to_string(c) + " is " +
                                             std::to_string(leaf.integer(c)) +
                                             ", which is not in shape_map");
    if (found->second->vtk == 42)
      refuse_shape(node, "polyhedral");
    types[c] = found->second->vtk;
    if (found->second->dimensions < 3)
      ++flat[found->second->name];
  }
  d.cells.types = in_place ? insitu_array_of(leaf.data, INSITU_UINT8, leaf.count, 1)
                           : insitu_array_of(types, INSITU_UINT8, leaf.count, 1);
  if (!in_place)
    d.cells.types.converted = "shapes have other numbers than VTK's, or other types";
  for (const auto& [name, number] : flat)
    d.left_out.push_back(elements.path() + ": " + std::to_string(number) + " cells of shape " +
                         name + " have no volume");
  if (!flat.empty()) { // they keep their numbers, and are hidden
    std::uint8_t* ghosts = d.copies.make<std::uint8_t>(leaf.count);
    for (std::int64_t c = 0; c < leaf.count; ++c)
      ghosts[c] = types[c] < 10 ? 32 : 0;
    d.ghosts = insitu_array_of(ghosts, INSITU_UINT8, leaf.count, 1);
    d.ghosts->converted = "cells without volume are hidden";
  }
}

void read_offsets(const Node& elements, Domain& d) {
  const std::int64_t cells = d.cells.types.count;
  if (const Node offsets = elements.find("offsets")) {
    d.cells.offsets = ids(offsets, d.copies);
    if (d.cells.offsets.count != cells && d.cells.offsets.count != cells + 1)
      offsets.refuse(INSITU_ERROR_ARGUMENT, "has " + std::to_string(d.cells.offsets.count) +
                                                " numbers for " + std::to_string(cells) + " cells");
    return;
  }
  const Node sizes = elements.at("sizes");
  const Leaf leaf = sizes.leaf();
  if (leaf.count != cells)
    sizes.refuse(INSITU_ERROR_ARGUMENT, "has " + std::to_string(leaf.count) + " numbers for " +
                                            std::to_string(cells) + " cells");
  std::int64_t* offsets = d.copies.make<std::int64_t>(cells + 1);
  offsets[0] = 0;
  for (std::int64_t c = 0; c < cells; ++c) {
    if (leaf.integer(c) < 0 || leaf.integer(c) > INT32_MAX)
      sizes.refuse(INSITU_ERROR_ARGUMENT,
                   "of cell " + std::to_string(c) + " is " + std::to_string(leaf.integer(c)));
    offsets[c + 1] = offsets[c] + leaf.integer(c);
  }
  d.cells.offsets = insitu_array_of(offsets, INSITU_INT64, cells + 1, 1);
  d.cells.offsets.converted = "the tree has sizes without offsets";
}

} // namespace

int dimensions_of(const std::string& shape) {
  const ShapeName* known = shape_of(shape);
  return known ? known->dimensions : -1;
}

void read_cells(const Node& topology, Domain& d) {
  d.kind = Domain::Kind::cells;
  const Node elements = topology.at("elements");
  if (elements.at("shape").text() != "mixed")
    return read_one_shape(elements, d);
  d.cells.layout = INSITU_LAYOUT_MIXED;
  read_types(elements, d);
  read_offsets(elements, d);
  d.cells.connectivity = ids(elements.at("connectivity"), d.copies);
  d.cells.count = d.cell_count = d.cells.types.count;
}

} // namespace insitu::blueprint

#include <algorithm>
#include <map>

#include "domain.h"
#include "lists.h"
#include "shapes.h"

namespace insitu::blueprint {

namespace {

void read_one_shape(const Node& elements, Domain& d) {
  const Node shape_node = elements.at("shape");
  const ShapeName* shape = shape_of(shape_node.text());
  if (!shape || shape->dimensions != d.dimensions || shape->ids == 0)
    refuse_shape(shape_node, shape_node.text());
  const Node connectivity = elements.at("connectivity");
  d.cells.layout = INSITU_LAYOUT_UNIFORM;
  d.cells.shape = static_cast<insitu_shape>(shape->vtk);
  insitu_array all = ids(connectivity, *d.cell_copies);
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

/// VTK's numbers of the cells' shapes, in place where they are these already; the library then
/// finds what is no number of a shape.
void read_types(const Node& elements, Domain& d) {
  const Node node = elements.at("shapes");
  const Leaf leaf = node.leaf();
  if (!leaf.is_integer())
    node.refuse(INSITU_ERROR_ARGUMENT, "holds no integers");
  const Shapes shapes = shapes_of(elements.at("shape_map"));
  bool in_place = leaf.type == Conduit::uint8 && leaf.stride == 1;
  for (const Mapped& m : shapes)
    in_place = in_place && m.shape && m.number == m.shape->vtk && m.shape->ids > 0 &&
               m.shape->dimensions == d.dimensions;
  if (in_place) {
    d.cells.types = insitu_array_of(leaf.data, INSITU_UINT8, leaf.count, 1);
    return;
  }
  d.cell_count = leaf.count;
  auto* types = d.cell_copies->make<std::uint8_t>(leaf.count);
  std::map<std::string, std::int64_t> lower;
  for (std::int64_t c = 0; c < leaf.count; ++c) {
    const ShapeName& shape = shape_at(node, leaf, c, shapes);
    types[c] = shape.vtk;
    if (shape.dimensions < d.dimensions)
      ++lower[shape.name];
  }
  d.cells.types = insitu_array_of(types, INSITU_UINT8, leaf.count, 1);
  d.cells.types.converted = "shapes have other numbers than VTK's, or other types";
  hide_lower(elements, lower, types, d);
}

/// The sums of a relation's sizes, from 0 on: one more than there are sizes.
insitu_array summed(const Node& relation, Copies& copies) {
  const Leaf leaf = sizes_of(relation.at("sizes"));
  auto* offsets = copies.make<std::int64_t>(leaf.count + 1);
  offsets[0] = 0;
  for (std::int64_t i = 0; i < leaf.count; ++i)
    offsets[i + 1] = offsets[i] + leaf.integer(i);
  insitu_array out = insitu_array_of(offsets, INSITU_INT64, leaf.count + 1, 1);
  out.converted = "the tree has sizes without their sums";
  return out;
}

void read_offsets(const Node& elements, Domain& d) {
  const std::int64_t cells = d.cells.types.count;
  const Node given = elements.find("offsets");
  d.cells.offsets = given ? ids(given, *d.cell_copies) : summed(elements, *d.cell_copies);
  if (d.cells.offsets.count != cells + 1 && !(given && d.cells.offsets.count == cells))
    elements.refuse(INSITU_ERROR_ARGUMENT, "has offsets or sizes of " +
                                               std::to_string(d.cells.offsets.count - !given) +
                                               " cells, and shapes of " + std::to_string(cells));
}

/// Where the items of a relation begin among so many ids of its connectivity: the tree's offsets,
/// where they are, or the sums of the sizes.
struct Places {
  insitu_array offsets;
  std::int64_t items;
};

/// Refuses offsets that are others than those of packed items, as the sizes tell them. Returns
/// where the last item ends.
std::int64_t end_of_packed(const Node& given, const Leaf& offsets, const Leaf& sizes,
                           std::int64_t ids) {
  std::int64_t at = offsets.count > 0 ? offsets.integer(0) : 0;
  for (std::int64_t i = 0; i < offsets.count; ++i) {
    const std::int64_t offset = offsets.integer(i);
    if (offset < 0 || offset > ids)
      given.refuse(INSITU_ERROR_ARGUMENT, "of item " + std::to_string(i) + " is " +
                                              std::to_string(offset) + ", and there are " +
                                              std::to_string(ids) + " ids");
    if (offset != at)
      given.refuse(INSITU_ERROR_UNSUPPORTED,
                   "of item " + std::to_string(i) + " is " + std::to_string(offset) +
                       "; packed items are supported, of which this one begins at " +
                       std::to_string(at));
    if (i < sizes.count) // which are below the greatest number of 32 bits
      at += sizes.integer(i);
  }
  return at;
}

Places read_places(const Node& relation, std::int64_t ids_count, Copies& copies) {
  const Node given = relation.find("offsets");
  if (!given) {
    const insitu_array sums = summed(relation, copies);
    return {sums, sums.count - 1};
  }
  const insitu_array in_place = ids(given, copies);
  const Leaf offsets = given.leaf();
  std::int64_t items = offsets.count;
  const Node counts = relation.find("sizes");
  if (!counts) { // every item has ids, so that none begins where all end
    items -= items > 0 && offsets.integer(items - 1) == ids_count;
    return {in_place, items};
  }
  const Leaf sizes = sizes_of(counts);
  items = sizes.count;
  if (offsets.count != items && offsets.count != items + 1)
    given.refuse(INSITU_ERROR_ARGUMENT, "has " + std::to_string(offsets.count) +
                                            " numbers, sizes has " + std::to_string(items));
  const std::int64_t end = end_of_packed(given, offsets, sizes, ids_count);
  if (offsets.count == items && end != ids_count) { // ids behind the last item's are no item's
    insitu_array with_end = summed(relation, copies);
    auto* place = static_cast<std::int64_t*>(const_cast<void*>(with_end.data)); // our own copy
    for (std::int64_t i = 0; items > 0 && i <= items; ++i)
      place[i] += offsets.integer(0);
    with_end.converted = "the offsets do not tell where the last item ends";
    return {with_end, items};
  }
  return {in_place, items};
}

/// Cells as lists of faces (elements), and faces as lists of vertices (subelements).
void read_polyhedra(const Node& topology, Domain& d) {
  d.kind = Domain::Kind::faces;
  const Node elements = topology.at("elements"), faces = topology.at("subelements");
  d.faces.form = INSITU_FACES_CELLS;
  d.faces.vertices = ids(faces.at("connectivity"), *d.cell_copies);
  const Places of_faces = read_places(faces, d.faces.vertices.count, *d.cell_copies);
  d.faces.offsets = of_faces.offsets;
  d.faces.face_count = of_faces.items;
  d.faces.cell_faces = ids(elements.at("connectivity"), *d.cell_copies);
  const Places of_cells = read_places(elements, d.faces.cell_faces.count, *d.cell_copies);
  d.faces.cell_offsets = of_cells.offsets;
  d.faces.cell_count = d.cell_count = of_cells.items;
}

/// Whether one of the cells has the shape: of mixed ones not only the map names it.
bool has_cells_of(const Node& topology, const std::string& shape) {
  const auto has = [&](const Node& elements) {
    const std::string own = elements.at("shape").text();
    if (own != "mixed")
      return own == shape;
    const Node number = elements.at("shape_map").find(shape);
    if (!number)
      return false;
    const std::int64_t wanted = number.integer();
    const Leaf numbers = elements.at("shapes").leaf();
    for (std::int64_t c = 0; c < numbers.count; ++c)
      if (numbers.integer(c) == wanted)
        return true;
    return false;
  };
  const Node elements = topology.at("elements");
  if (elements.find("shape"))
    return has(elements);
  for (std::int64_t i = 0; i < elements.size(); ++i)
    if (has(elements.child(i)))
      return true;
  return false;
}

/// A list of topologies of one shape each as mixed cells.
void read_list(const Node& topology, Domain& d) {
  const CellLists lists(topology);
  d.cells.layout = INSITU_LAYOUT_MIXED;
  d.cells.count = d.cell_count = lists.count();
  auto* types = d.cell_copies->make<std::uint8_t>(d.cell_count);
  auto* offsets = d.cell_copies->make<std::int64_t>(d.cell_count + 1);
  std::vector<std::int64_t> ids;
  std::map<std::string, std::int64_t> lower;
  offsets[0] = 0;
  lists.for_each([&](const CellLists::Cell& cell) {
    types[cell.number] = cell.shape->vtk;
    if (cell.shape->dimensions < d.dimensions)
      ++lower[cell.shape->name];
    ids.insert(ids.end(), cell.ids.begin(), cell.ids.end());
    offsets[cell.number + 1] = static_cast<std::int64_t>(ids.size());
  });
  constexpr const char* reason = "a list of topologies of one shape each";
  d.cells.types = insitu_array_of(types, INSITU_UINT8, d.cell_count, 1);
  d.cells.offsets = insitu_array_of(offsets, INSITU_INT64, d.cell_count + 1, 1);
  d.cells.connectivity = d.cell_copies->array(ids);
  for (insitu_array* a : {&d.cells.types, &d.cells.offsets, &d.cells.connectivity})
    a->converted = reason;
  hide_lower(topology.at("elements"), lower, types, d);
}

} // namespace

void hide_lower(const Node& elements, const std::map<std::string, std::int64_t>& lower,
                const std::uint8_t* types, Domain& d) {
  for (const auto& [name, number] : lower)
    d.left_out.push_back(elements.path() + ": " + std::to_string(number) + " cells of shape " +
                         name + (d.dimensions == 3 ? " have no volume" : " have no area"));
  if (lower.empty())
    return;
  const std::int64_t cells = d.cell_count;
  auto* ghosts = d.cell_copies->make<std::uint8_t>(cells); // they keep their numbers
  for (std::int64_t c = 0; c < cells; ++c)
    ghosts[c] = types[c] < (d.dimensions == 3 ? INSITU_TETRAHEDRON : INSITU_TRIANGLE) ? 32 : 0;
  d.ghosts = insitu_array_of(ghosts, INSITU_UINT8, cells, 1);
  d.ghosts->converted =
      d.dimensions == 3 ? "cells without volume are hidden" : "cells without area are hidden";
}

void read_cells(const Node& topology, Domain& d) {
  d.kind = Domain::Kind::cells;
  const Node elements = topology.at("elements");
  const bool is_list = !elements.find("shape");
  if (has_cells_of(topology, "polyhedral")) {
    const Node faces = topology.at("subelements");
    const std::string shape = faces.at("shape").text();
    const bool is_given = faces.find("sizes") || faces.find("offsets");
    if (!is_list && elements.at("shape").text() == "polyhedral" && is_given &&
        (shape == "polygonal" || shape == "mixed"))
      return read_polyhedra(topology, d);
    return read_polyhedra_among_others(topology, d);
  }
  if (d.dimensions == 2 && has_cells_of(topology, "polygonal"))
    return read_polygons(topology, d);
  if (is_list)
    return read_list(topology, d);
  if (elements.at("shape").text() != "mixed")
    return read_one_shape(elements, d);
  d.cells.layout = INSITU_LAYOUT_MIXED;
  read_types(elements, d);
  read_offsets(elements, d);
  d.cells.connectivity = ids(elements.at("connectivity"), *d.cell_copies);
  d.cells.count = d.cell_count = d.cells.types.count;
}

} // namespace insitu::blueprint

#include <algorithm>

#include "domain.h"

namespace insitu::blueprint {

namespace {

/// What ParaView's metadata say of a field (Ghosts, GlobalIds, ...), and what names tell.
std::string role_of(const Node& mesh, const Node& channel, const std::string& name) {
  const std::string path = "state/metadata/vtk_fields/" + name + "/attribute_type";
  for (const Node& at : {mesh, channel})
    if (const Node type = at.find(path); type && type.is_text())
      return type.text();
  return name == "vtkGhostType" ? "Ghosts" : name == "ascent_ghosts" ? "ascent" : "";
}

/// The items of a field's array that are the topology's, where polygons are cut with those of what
/// they become.
void set_items(const Node& field, const Node& values, bool on_cells, const Domain& d,
               Copies& copies, insitu_array& array) {
  const std::int64_t items = on_cells ? d.cell_count : d.vertex_count;
  std::array<std::int64_t, 3> extent = d.extent;
  for (std::size_t a = 0; a < std::size_t(d.dimensions); ++a)
    extent[a] -= on_cells ? 1 : 0;
  if (d.kind == Domain::Kind::block)
    if (const Window window = read_window(field, extent, array.count); window.given) {
      array = block_of(array, extent, window.offset, window.stride);
      return;
    }
  if (array.count != items)
    values.refuse(INSITU_ERROR_FIELD, "has " + std::to_string(array.count) +
                                          " items, the topology has " + std::to_string(items) +
                                          (on_cells ? " elements" : " vertices"));
  if (d.cuts)
    array = d.cuts->expanded(array, on_cells, copies);
}

/// Ghosts of cells; cells that are hidden already stay hidden.
void set_ghosts(const Node& field, const Node& values, insitu_ghost_convention convention,
                Domain& d) {
  insitu_array given = bytes(values, *d.cell_copies);
  set_items(field, values, true, d, *d.cell_copies, given);
  if (!d.ghosts) {
    d.ghosts = given;
    d.convention = convention;
    return;
  }
  const Leaf leaf = values.leaf();
  auto* hidden = static_cast<std::uint8_t*>(const_cast<void*>(d.ghosts->data)); // our own copy
  for (std::int64_t c = 0; c < std::min(leaf.count, d.ghosts->count); ++c)
    if (const std::int64_t bits = leaf.integer(c))
      hidden[c] |= static_cast<std::uint8_t>(convention == INSITU_GHOSTS_VTK ? bits
                                             : bits == 1                     ? 1
                                                                             : 32);
}

/// Whether the field tells of cells or vertices what is no value.
bool read_role(const std::string& role, const Node& field, const Node& values, bool on_cells,
               Domain& d) {
  if (role == "ascent" && on_cells) {
    set_ghosts(field, values, INSITU_GHOSTS_ASCENT, d);
  } else if (role == "Ghosts" && on_cells) {
    set_ghosts(field, values, INSITU_GHOSTS_VTK, d);
  } else if (role == "Ghosts") {
    insitu_array given = bytes(values, *d.cell_copies);
    set_items(field, values, false, d, *d.cell_copies, given);
    d.hidden_points = given;
  } else if (role == "GlobalIds" && d.are_polygons) {
    d.left_out.push_back(field.path() + ": polygons may be cut, and parts have no global ids");
  } else if (role == "GlobalIds") {
    insitu_array given = ids(values, *d.cell_copies);
    set_items(field, values, on_cells, d, *d.cell_copies, given);
    d.global_ids[on_cells ? INSITU_CELL : INSITU_VERTEX] = given;
  } else {
    return role == "ascent";
  }
  return true;
}

/// The polygons' numbers, which may be cut into several cells each.
void add_numbers(Domain& d) {
  auto* numbers = d.copies.make<double>(d.cell_count);
  for (std::int64_t c = 0; c < d.cell_count; ++c)
    numbers[c] = static_cast<double>(c);
  insitu_array array = insitu_array_of(numbers, INSITU_FLOAT64, d.cell_count, 1);
  array.converted = "numbers of polygons";
  d.fields.push_back(
      {"blueprint_cell", INSITU_CELL, {d.cuts ? d.cuts->expanded(array, true, d.copies) : array}});
}

void read_values(const Node& field, const Node& values, bool on_cells, Domain& d) {
  if (values.is_text()) {
    d.left_out.push_back(field.path() + ": text");
    return;
  }
  Field out{field.name(), on_cells ? INSITU_CELL : INSITU_VERTEX, components(values, d.copies)};
  for (insitu_array& array : out.arrays)
    set_items(field, values, on_cells, d, d.copies, array);
  d.fields.push_back(std::move(out));
}

} // namespace

void read_fields(const Node& mesh, const Node& topology, const Node& channel, Domain& d) {
  const Node all = mesh.find("fields");
  for (std::int64_t i = 0; i < all.size(); ++i) {
    const Node field = all.child(i);
    const std::string name = field.name();
    const Node values = field.find("values"), on = field.find("association");
    const Node of = field.find("topology");
    if (of && of.is_text() && of.text() != topology.name())
      continue;
    if (!values || !on) {
      d.left_out.push_back(field.path() + (values ? ": no association" : ": no values") +
                           (field.find("basis") ? ", but a basis of high order" : ""));
      continue;
    }
    const bool on_cells = on.text() == "element";
    if (!on_cells && on.text() != "vertex")
      on.refuse(INSITU_ERROR_ARGUMENT, "is '" + on.text() + "'; vertex or element is needed");
    try {
      if (!read_role(role_of(mesh, channel, name), field, values, on_cells, d))
        read_values(field, values, on_cells, d);
    } catch (const Error& e) { // of several topologies it may be on another one
      if (of || e.status() != INSITU_ERROR_FIELD || mesh.at("topologies").size() < 2)
        throw;
      d.left_out.push_back(std::string(e.what()) + ", and no topology is named");
    }
  }
  if (d.are_polygons)
    add_numbers(d);
}

} // namespace insitu::blueprint

#include "mesh/registered/mesh.h"

#include <algorithm>
#include <cmath>

#include "core/caller_struct.h"
#include "core/suggest.h"

namespace insitu::mesh {

using core::Error;

namespace {

std::string piece_text(std::int32_t piece) {
  return "piece " + std::to_string(piece);
}

/// Arrays that together hold the components of one quantity: of equal type, count and strides.
struct Components {
  std::vector<const std::byte*> base;
  std::vector<std::int64_t> behind; ///< where in the records, if the items lie behind pointers
  ItemLayout layout;
  bool is_float32;
};

Components join(const std::vector<ExternalArray>& arrays, const std::string& name) {
  Components out;
  out.layout = arrays[0].layout;
  out.is_float32 = arrays[0].type == INSITU_FLOAT32;
  if (arrays.size() == 1) {
    const std::byte* data = arrays[0].data; // null if there are no items
    for (int c = 0; c < arrays[0].components; ++c)
      if (arrays[0].indirect) {
        out.base.push_back(data);
        out.behind.push_back(arrays[0].offset + c * arrays[0].component_stride);
      } else {
        out.base.push_back(data ? data + c * arrays[0].component_stride : nullptr);
      }
    return out;
  }
  for (std::size_t i = 0; i < arrays.size(); ++i) {
    const ExternalArray& a = arrays[i];
    const std::string one = name + ", array " + std::to_string(i);
    if (a.components != 1)
      throw Error(INSITU_ERROR_ARGUMENT,
                  one + ": " + std::to_string(a.components) +
                      " components; separate arrays hold one component each");
    const ItemLayout &l = a.layout, &first = arrays[0].layout;
    const bool same_places = l.linear ? l.stride[0] == first.stride[0]
                                      : std::equal(l.stride, l.stride + 3, first.stride) &&
                                            std::equal(l.extent, l.extent + 2, first.extent);
    if (a.indirect != arrays[0].indirect)
      throw Error(INSITU_ERROR_ARGUMENT, one + ": " + (a.indirect ? "" : "not ") +
                                             "indirect, unlike array 0; all or none expected");
    if (a.type != arrays[0].type || l.count != first.count || l.linear != first.linear ||
        !same_places)
      throw Error(INSITU_ERROR_ARGUMENT,
                  one + ": type " + type_name(a.type) + ", count " + std::to_string(l.count) +
                      ", stride " + std::to_string(l.stride[0]) + " differ from array 0's " +
                      type_name(arrays[0].type) + ", " + std::to_string(first.count) + ", " +
                      std::to_string(first.stride[0]));
    out.base.push_back(a.data);
    if (a.indirect)
      out.behind.push_back(a.offset);
  }
  return out;
}

std::vector<ExternalArray> adopt_all(const insitu_array* arrays, std::int32_t count,
                                     const std::string& name, Pointers pointers) {
  if (!arrays || count < 1)
    throw Error(INSITU_ERROR_ARGUMENT,
                name + ": " + (arrays ? std::to_string(count) + " arrays" : "arrays is null"));
  std::vector<ExternalArray> out;
  for (std::int32_t i = 0; i < count; ++i) {
    out.push_back(
        adopt(arrays + i, count == 1 ? name : name + ", array " + std::to_string(i), pointers));
    require_real(out.back(), name);
  }
  return out;
}

} // namespace

void Mesh::Piece::set_cells_view(PieceView cells) {
  cells.points = view.points;
  cells.ghosts = view.ghosts;
  cells.ghost_layout = view.ghost_layout;
  cells.ghost_mask = view.ghost_mask;
  view = cells;
  connectivity = types = offsets = {};
  face_arrays.clear();
  faces.reset();
  flat_cells = {};
  flat.reset();
  left_out.reset();
  for (ExternalArray& axis : axes)
    axis = {};
  has_cells = true;
  is_block = false;
}

Mesh::Mesh(std::string name, core::Memory& memory)
    : name_(std::move(name)), memory_(&memory), earlier_points_(memory, INSITU_MEMORY_EARLIER),
      earlier_axes_(memory, INSITU_MEMORY_EARLIER) {
  view_.first_cell = first_cell_.data();
  view_.first_vertex = first_vertex_.data();
}

Mesh::Piece& Mesh::piece_for(std::int32_t piece) {
  if (piece < 0 || std::size_t(piece) > pieces_.size())
    throw Error(INSITU_ERROR_ARGUMENT,
                "mesh '" + name_ + "': piece " + std::to_string(piece) +
                    "; pieces are numbered from 0 without gaps, the next is " +
                    std::to_string(pieces_.size()));
  if (std::size_t(piece) == pieces_.size())
    pieces_.emplace_back();
  return pieces_[std::size_t(piece)];
}

void Mesh::set_points(std::int32_t piece, const insitu_array* arrays, std::int32_t array_count) {
  const std::string name = "mesh '" + name_ + "', " + piece_text(piece) + " points";
  refuse_if_adaptive(name);
  std::vector<ExternalArray> adopted = adopt_all(arrays, array_count, name, Pointers::refused);
  const Components joined = join(adopted, name);
  const auto components = int(joined.base.size());
  if (components != 3 && components != 2)
    throw Error(INSITU_ERROR_ARGUMENT,
                name + ": " + std::to_string(components) +
                    " components, 3 expected (one array of 3, or 3 arrays), or 2 of a flat mesh");
  Piece& p = piece_for(piece);
  // The same vertices in another place are changed geometry; another number is another topology.
  pending_ |= p.has_points && p.view.points.layout.count == joined.layout.count &&
                      p.point_components == components
                  ? INSITU_CHANGED_GEOMETRY
                  : INSITU_CHANGED_ALL;
  std::copy(joined.base.begin(), joined.base.end(), p.view.points.component);
  p.view.points.layout = joined.layout;
  p.view.points.is_float32 = joined.is_float32;
  p.point_components = components;
  p.points = std::move(adopted);
  p.has_points = true;
}

void Mesh::set_cells(std::int32_t piece, const insitu_cells* given) {
  const std::string name = "mesh '" + name_ + "', " + piece_text(piece) + " cells";
  const auto refuse = [&](const std::string& what) {
    throw Error(INSITU_ERROR_ARGUMENT, name + ": " + what);
  };
  refuse_if_adaptive(name);
  const insitu_cells copy = core::from_caller(given, name), *const cells = &copy;
  if (cells->count < 0 || cells->count > (std::int64_t(1) << 40))
    refuse("count " + std::to_string(cells->count));
  if (cells->index_base != 0 && cells->index_base != 1)
    refuse("index_base " + std::to_string(cells->index_base) + ", 0 or 1 expected");
  if (cells->layout < INSITU_LAYOUT_UNIFORM || cells->layout > INSITU_LAYOUT_PADDED)
    refuse("unknown layout " + std::to_string(int(cells->layout)));
  const bool mixed = cells->layout == INSITU_LAYOUT_MIXED;
  const bool flat = !mixed && is_flat_shape(int(cells->shape));
  if (!mixed && !flat && !is_shape(int(cells->shape)))
    refuse("unknown shape " + std::to_string(int(cells->shape)));
  if (cells->layout == INSITU_LAYOUT_PADDED && cells->shape == INSITU_TRIANGLE)
    refuse("padded triangles; the shape of 4 ids is PIXEL or QUAD");

  PieceView v;
  v.layout = cells->layout == INSITU_LAYOUT_UNIFORM ? CellLayout::uniform
             : mixed                                ? CellLayout::mixed
                                                    : CellLayout::padded;
  v.cell_count = cells->count;
  v.index_base = cells->index_base;
  v.uniform_shape = mixed || flat ? Shape::none : Shape(cells->shape);
  if (cells->layout == INSITU_LAYOUT_PADDED && !flat && v.uniform_shape != Shape::voxel)
    v.uniform_shape = Shape::hexahedron;

  const ExternalArray connectivity = adopt(&cells->connectivity, name + ", connectivity");
  ExternalArray types, offsets;
  require_integer(connectivity, name + ", connectivity");
  if (!connectivity.layout.linear)
    refuse("connectivity: items must be evenly spaced");
  const auto index_view = [](const ExternalArray& a) {
    return IndexView{a.data, a.layout.count, a.layout.stride[0], a.type == INSITU_INT32};
  };
  v.connectivity = index_view(connectivity);
  if (mixed) {
    if (connectivity.components != 1)
      refuse("connectivity: " + std::to_string(connectivity.components) +
             " components; in the mixed layout an item is one id");
    v.id_stride = connectivity.layout.stride[0];
    types = adopt(&cells->types, name + ", types");
    offsets = adopt(&cells->offsets, name + ", offsets");
    require_integer(offsets, name + ", offsets");
    if (types.type != INSITU_UINT8)
      refuse(std::string("types: type ") + type_name(types.type) + ", uint8 expected");
    if (!types.layout.linear || !offsets.layout.linear)
      refuse("types and offsets: items must be evenly spaced");
    if (types.layout.count < cells->count || offsets.layout.count < cells->count)
      refuse(std::to_string(cells->count) + " cells, but " + std::to_string(types.layout.count) +
             " types and " + std::to_string(offsets.layout.count) + " offsets");
    v.types = types.data;
    v.types_stride = types.layout.stride[0];
    v.offsets = index_view(offsets);
  } else {
    const int expected = flat ? (cells->shape == INSITU_TRIANGLE ? 3 : 4)
                         : cells->layout == INSITU_LAYOUT_PADDED
                             ? 8
                             : vertex_count(Shape(cells->shape));
    if (connectivity.components != expected)
      refuse("connectivity: " + std::to_string(connectivity.components) + " ids a cell, " +
             std::to_string(expected) + " expected");
    if (connectivity.layout.count < cells->count)
      refuse(std::to_string(cells->count) + " cells, but connectivity holds " +
             std::to_string(connectivity.layout.count));
    v.id_stride = connectivity.component_stride;
  }

  Piece& p = piece_for(piece);
  p.set_cells_view(v);
  p.given = copy;
  p.connectivity = connectivity;
  p.types = types;
  p.offsets = offsets;
  if (flat)
    p.flat_cells = {cells->layout == INSITU_LAYOUT_UNIFORM ? FlatCells::Kind::uniform
                                                           : FlatCells::Kind::padded,
                    std::uint8_t(cells->shape)};
  pending_ |= INSITU_CHANGED_ALL;
}

void Mesh::set_field(std::int32_t piece, const std::string& name, insitu_association association,
                     const insitu_array* arrays, std::int32_t array_count) {
  const std::string text = "mesh '" + name_ + "', " + piece_text(piece) + ", field '" + name + "'";
  if (name.empty())
    throw Error(INSITU_ERROR_ARGUMENT, "mesh '" + name_ + "': a field's name is empty");
  if (association != INSITU_VERTEX && association != INSITU_CELL)
    throw Error(INSITU_ERROR_ARGUMENT,
                text + ": unknown association " + std::to_string(int(association)));
  std::vector<ExternalArray> adopted = adopt_all(arrays, array_count, text, Pointers::followed);
  Components joined = join(adopted, text);
  const Field* known = find(name);
  const auto components = int(joined.base.size());
  if (known && pieces_.size() > 1 &&
      (known->association != association || known->components != components))
    throw Error(INSITU_ERROR_ARGUMENT,
                text + ": " + std::to_string(components) + " components on " +
                    (association == INSITU_CELL ? "cells" : "vertices") +
                    ", but other pieces have " + std::to_string(known->components) + " on " +
                    (known->association == INSITU_CELL ? "cells" : "vertices"));
  (void)piece_for(piece);
  Field* field = const_cast<Field*>(known);
  if (!field)
    field = fields_.emplace_back(std::make_unique<Field>()).get();
  field->name = name;
  field->association = association;
  field->components = components;
  field->pieces.resize(std::max(field->pieces.size(), std::size_t(piece) + 1));
  FieldPiece& to = field->pieces[std::size_t(piece)];
  to.components = std::move(joined.base);
  to.behind = std::move(joined.behind);
  to.pointers_checked = to.behind.empty();
  to.layout = joined.layout;
  to.is_float32 = joined.is_float32;
  to.arrays = std::move(adopted);
  pending_ |= INSITU_CHANGED_FIELDS;
}

void Mesh::remove_field(const std::string& name) {
  (void)own_field(name); // throws if there is none
  std::erase_if(fields_, [&](const auto& f) { return f->name == name; });
  pending_ |= INSITU_CHANGED_FIELDS;
}

void Mesh::set_ghosts(std::int32_t piece, const insitu_array* array,
                      insitu_ghost_convention convention) {
  const std::string name = "mesh '" + name_ + "', " + piece_text(piece) + " ghosts";
  refuse_if_adaptive(name);
  if (convention != INSITU_GHOSTS_VTK && convention != INSITU_GHOSTS_ASCENT)
    throw Error(INSITU_ERROR_ARGUMENT,
                name + ": unknown convention " + std::to_string(int(convention)));
  ExternalArray adopted;
  if (array) {
    adopted = adopt(array, name);
    if (adopted.type != INSITU_UINT8 || adopted.components != 1)
      throw Error(INSITU_ERROR_ARGUMENT, name + ": one uint8 a cell expected, " +
                                             std::to_string(adopted.components) + " of " +
                                             type_name(adopted.type) + " given");
  }
  Piece& p = piece_for(piece);
  constexpr std::uint8_t vtk_bits = 1 | 8 | 32; // duplicate, refined, hidden
  p.view.ghosts = array ? adopted.data : nullptr;
  p.view.ghost_layout = adopted.layout;
  p.view.ghost_mask = convention == INSITU_GHOSTS_VTK ? vtk_bits : std::uint8_t(0xff);
  p.ghosts = adopted;
  pending_ |= INSITU_CHANGED_ALL;
}

const Mesh::Field* Mesh::find(const std::string& name) const {
  for (const auto& f : fields_)
    if (f->name == name)
      return f.get();
  return nullptr;
}

bool Mesh::has_field(const std::string& name) const {
  return find(name) != nullptr;
}

std::vector<std::string> Mesh::field_names() const {
  std::vector<std::string> names;
  for (const auto& f : fields_)
    names.push_back(f->name);
  return names;
}

FieldView Mesh::field(const std::string& name) const {
  const FieldView own = own_field(name);
  return stand_in_ ? stand_in_->field(own) : own;
}

FieldView Mesh::own_field(const std::string& name) const {
  const Field* f = find(name);
  if (!f) {
    const std::vector<std::string> names = field_names();
    std::string message = "mesh '" + name_ + "' has no field '" + name + "'";
    const std::string nearest = core::suggest(name, names);
    if (!nearest.empty())
      message += "; did you mean '" + nearest + "'?";
    message += " (fields:";
    for (const std::string& n : names)
      message += " " + n;
    throw Error(INSITU_ERROR_FIELD, message + (names.empty() ? " none)" : ")"));
  }
  return {f->name.c_str(), f->association, f->components, f->views.data(), has_blanks(*f)};
}

} // namespace insitu::mesh

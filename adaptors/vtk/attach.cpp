#include <algorithm>
#include <map>
#include <vtkAbstractArray.h>
#include <vtkCellData.h>
#include <vtkDataSet.h>
#include <vtkDataSetAttributes.h>
#include <vtkPointData.h>

#include "insitu/vtk.hpp"

#include "arrays.h"
#include "topology.h"

namespace insitu::vtk {

namespace {

/// A field that was given, with what owns its values.
struct Given {
  Association association = Association::vertex;
  Watched source;
  Adopted adopted;
};

using Fields = std::map<std::string, Given>;

Array ids_of(vtkDataArray* array) {
  const std::int64_t values = array->GetNumberOfValues();
  if (array->GetDataTypeSize() == 4)
    return {static_cast<const std::int32_t*>(array->GetVoidPointer(0)), values};
  return {static_cast<const std::int64_t*>(array->GetVoidPointer(0)), values};
}

Array bytes_of(vtkDataArray* array) {
  return {static_cast<const std::uint8_t*>(array->GetVoidPointer(0)), array->GetNumberOfValues()};
}

const char* const made_faces = "VTK has the faces of polyhedra cell by cell";

} // namespace

struct Attachment::State {
  State(const Mesh& m, const AttachOptions& o) : options(o), mesh(m), piece(mesh.piece(o.piece)) {}

  Change update(vtkDataSet* data);

  std::vector<Note> converted, skipped;

private:
  void collect(vtkDataSetAttributes* attributes, Association association, Fields& out,
               std::vector<Note>& left_out) const;
  bool wanted(const std::string& name) const {
    return options.arrays.empty() ||
           std::find(options.arrays.begin(), options.arrays.end(), name) != options.arrays.end();
  }
  void give_cells(const Topology& t);
  void give_axes(const Topology& t);
  void give_points(const Topology& t);
  /// anew: what is equal, too.
  bool give_fields(const Fields& now, bool anew);
  bool give_hidden_points(const Watched& now);
  void give_blanks(vtkDataSet* data);
  void note(const std::string& name, const char* reason) {
    if (reason)
      converted.push_back({name, reason});
  }

  AttachOptions options;
  Mesh mesh;
  Piece piece;
  bool attached = false;
  Topology topology;      ///< as given; holds its arrays
  Watched points;         ///< as given
  Watched hidden;         ///< as given: point ghosts
  Adopted adopted_points; ///< of that
  Adopted adopted_axes[3];
  Fields given;
};

void Attachment::State::collect(vtkDataSetAttributes* attributes, Association association,
                                Fields& out, std::vector<Note>& left_out) const {
  const bool cell = association == Association::cell;
  for (int i = 0; i < attributes->GetNumberOfArrays(); ++i) {
    vtkAbstractArray* any = attributes->GetAbstractArray(i);
    const std::string name = any->GetName() ? any->GetName() : "";
    const std::string text = (cell ? "cell array '" : "point array '") + name + "'";
    auto* array = vtkDataArray::SafeDownCast(any);
    if (name == vtkDataSetAttributes::GhostArrayName() || !wanted(name)) {
      continue; // ghosts are read by themselves
    } else if (name.empty()) {
      left_out.push_back({text, "has no name"});
    } else if (!array) {
      left_out.push_back({text, std::string(any->GetClassName()) + " holds no numbers"});
    } else if (array->GetNumberOfComponents() < 1) {
      left_out.push_back({text, "has no components"});
    } else if (!options.convert && reason_to_convert(array)) {
      left_out.push_back({text, reason_to_convert(array)});
    } else {
      const auto [known, fresh] = out.try_emplace(name, Given{association, Watched(array), {}});
      if (!fresh)
        left_out.push_back({text, known->second.association == association
                                      ? "another array has this name"
                                      : "a point array has this name"});
    }
  }
}

void Attachment::State::give_axes(const Topology& t) {
  const char* differ = nullptr;
  for (const Watched& axis : t.axes)
    if (axis.array->GetDataType() != t.axes[0].array->GetDataType())
      differ = "the axes' types differ";
  Adopted axes[3];
  for (int a = 0; a < 3; ++a)
    axes[a] =
        adopt(t.axes[a].array, t.axes[a].array->GetDataType() == VTK_DOUBLE ? nullptr : differ);
  if (t.is_flat)
    piece.flat_rectilinear_block(axes[0].arrays.at(0), axes[1].arrays.at(0));
  else
    piece.rectilinear_block(axes[0].arrays.at(0), axes[1].arrays.at(0), axes[2].arrays.at(0));
  std::move(axes, axes + 3, adopted_axes);
}

void Attachment::State::give_cells(const Topology& t) {
  switch (t.kind) {
  case Topology::Kind::uniform:
    if (t.is_flat)
      piece.flat_uniform_block({t.vertices[0], t.vertices[1]}, {t.origin[0], t.origin[1]},
                               {t.spacing[0], t.spacing[1]});
    else
      piece.uniform_block(t.vertices, t.origin, t.spacing);
    break;
  case Topology::Kind::rectilinear:
    give_axes(t);
    break;
  case Topology::Kind::curvilinear:
    if (t.is_flat)
      piece.flat_block(t.vertices[0], t.vertices[1]);
    else
      piece.block(t.vertices[0], t.vertices[1], t.vertices[2]);
    break;
  case Topology::Kind::faces: {
    const auto made = [](vtkDataArray* array) { return ids_of(array).converted(made_faces); };
    piece.faces_of_cells(made(t.faces.vertices), made(t.faces.offsets), made(t.faces.cell_faces),
                         made(t.faces.cell_offsets));
    break;
  }
  default:
    if (t.cells == 0) {
      piece.cells(Shape::hexahedron, static_cast<const std::int64_t*>(nullptr), 0);
    } else if (t.one_shape) {
      Array ids = ids_of(t.connectivity.array);
      piece.cells(t.shape, ids.count(t.cells));
    } else {
      piece.mixed_cells(bytes_of(t.types.array), ids_of(t.offsets.array),
                        ids_of(t.connectivity.array));
    }
  }
  if (t.ghosts.array)
    piece.ghosts(bytes_of(t.ghosts.array).converted(t.made_ghosts));
  else
    piece.no_ghosts();
}

void Attachment::State::give_points(const Topology& t) {
  if (!t.points.array) {
    const double* none = nullptr;
    piece.points(none, 0);
    return;
  }
  Adopted now = adopt(t.points.array);
  if (t.made_points) {
    now.reason = t.made_points;
    for (Array& a : now.arrays)
      a.converted(now.reason);
  }
  if (now.arrays.size() == 3)
    piece.points(now.arrays[0], now.arrays[1], now.arrays[2]);
  else
    piece.points(now.arrays.at(0));
  adopted_points = std::move(now);
}

bool Attachment::State::give_fields(const Fields& now, bool anew) {
  bool changed = false;
  for (const auto& [name, field] : now) {
    const auto before = given.find(name);
    if (!anew && before != given.end() && before->second.association == field.association &&
        same(before->second.source, field.source))
      continue;
    Given next = field;
    next.adopted = adopt(field.source.array);
    piece.field(name, field.association, next.adopted.arrays);
    given[name] = std::move(next);
    changed = true;
  }
  for (auto it = given.begin(); it != given.end();) {
    if (now.find(it->first) != now.end()) {
      ++it;
      continue;
    }
    try {
      mesh.remove_field(it->first);
    } catch (const Error& e) { // another piece's attachment may have removed it already
      if (e.status() != INSITU_ERROR_FIELD)
        throw;
    }
    it = given.erase(it);
    changed = true;
  }
  return changed;
}

/// Whether others are hidden than before.
bool Attachment::State::give_hidden_points(const Watched& now) {
  if (same(hidden, now))
    return false;
  if (now.array)
    piece.hidden_points(bytes_of(now.array));
  else
    piece.no_hidden_points();
  hidden = now;
  return true;
}

void Attachment::State::give_blanks(vtkDataSet* data) {
  for (const auto& [name, field] : given)
    for (const double value : blank_values(data->GetFieldData(), name))
      mesh.field_blank(name, value);
}

Change Attachment::State::update(vtkDataSet* data) {
  // All that can be refused here is refused before the mesh is touched.
  Topology next = topology_of(data);
  const char* made_hidden = nullptr;
  const Watched next_hidden(ghost_bytes(data->GetPointData(), &made_hidden, "point"));
  Fields now;
  std::vector<Note> left_out;
  collect(data->GetPointData(), Association::vertex, now, left_out);
  collect(data->GetCellData(), Association::cell, now, left_out);

  const vtkIdType cells_before = topology.cells;
  const bool new_topology = !attached || !same(topology, next);
  const bool has_points = next.kind == Topology::Kind::cells ||
                          next.kind == Topology::Kind::faces ||
                          next.kind == Topology::Kind::curvilinear;
  const bool new_points = has_points && (new_topology || !same(points, next.points));
  Change what{};
  if (new_topology) {
    give_cells(next);
    topology = next;
    what = what | everything;
  }
  if (new_points) {
    give_points(next);
    points = next.points;
    what = what | geometry;
  }
  // A piece without cells adds nothing, and takes no field from the others.
  const bool was_empty = attached && cells_before == 0;
  if (next.cells > 0) {
    if (give_fields(now, was_empty))
      what = what | insitu::fields;
    if (give_hidden_points(next_hidden))
      what = what | insitu::fields;
    give_blanks(data);
  }
  attached = true;

  converted.clear();
  skipped.clear();
  if (next.cells == 0)
    return what;
  skipped = std::move(left_out);
  if (!next.left_out.empty())
    skipped.push_back({next.left_out, "cells of lower dimension than others; their numbers stay"});
  if (next.made_ghosts)
    note("cell array 'vtkGhostType'", next.made_ghosts);
  if (made_hidden)
    note("point array 'vtkGhostType'", made_hidden);
  if (has_points)
    note("points", adopted_points.reason);
  if (topology.kind == Topology::Kind::faces)
    note("faces", made_faces);
  if (topology.kind == Topology::Kind::rectilinear)
    for (int a = 0; a < 3; ++a)
      note("axis " + std::to_string(a), adopted_axes[a].reason);
  for (const auto& [name, field] : given)
    note((field.association == Association::cell ? "cell array '" : "point array '") + name + "'",
         field.adopted.reason);
  return what;
}

Attachment::Attachment(std::unique_ptr<State> state) : state_(std::move(state)) {}
Attachment::Attachment(Attachment&&) noexcept = default;
Attachment& Attachment::operator=(Attachment&&) noexcept = default;
Attachment::~Attachment() = default;

Change Attachment::update(vtkDataSet* data) {
  return state_->update(data);
}
const std::vector<Note>& Attachment::converted() const {
  return state_->converted;
}
const std::vector<Note>& Attachment::skipped() const {
  return state_->skipped;
}

Attachment attach(Mesh& mesh, vtkDataSet* data, const AttachOptions& options) {
  auto state = std::make_unique<Attachment::State>(mesh, options);
  state->update(data);
  return Attachment(std::move(state));
}

} // namespace insitu::vtk

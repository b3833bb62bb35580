#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

#include "core/status.h"
#include "mesh/registered/copy_items.h"
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

using core::Error;

const std::byte* const no_values[1 << 16] = {};

void Mesh::check_piece(std::size_t index) const {
  const Piece& p = pieces_[index];
  const std::string name = "mesh '" + name_ + "', piece " + std::to_string(index);
  if (!p.has_cells)
    throw Error(INSITU_ERROR_ORDER,
                name + ": has no cells; call insitu_mesh_cells, _faces or _block first");
  if (p.view.cell_count == 0) // adds nothing, whatever else was given
    return;
  if (!p.view.implicit_points && !p.has_points)
    throw Error(INSITU_ERROR_ORDER, name + ": has no points; call insitu_mesh_points first");
  const std::int64_t points = p.view.points.layout.count;
  if (p.is_block && !p.view.implicit_points && points != p.view.vertex_count)
    throw Error(INSITU_ERROR_MESH, name + ": the block has " + std::to_string(p.view.vertex_count) +
                                       " vertices, but " + std::to_string(points) +
                                       " points are given");
  if (p.hidden_points.given() && p.hidden_points.layout.count < vertices_of(p))
    throw Error(INSITU_ERROR_MESH, name + ": " + std::to_string(p.hidden_points.layout.count) +
                                       " bytes of hidden points for " +
                                       std::to_string(vertices_of(p)) + " vertices");
  if (p.view.ghosts && p.view.ghost_layout.count < p.view.cell_count)
    throw Error(INSITU_ERROR_MESH, name + ": " + std::to_string(p.view.ghost_layout.count) +
                                       " ghost values for " + std::to_string(p.view.cell_count) +
                                       " cells");
}

void Mesh::check_field(const Field& field) const {
  const std::string name = "mesh '" + name_ + "', field '" + field.name + "'";
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    if (first_cell_[p + 1] == first_cell_[p]) // adds nothing, with values or without
      continue;
    if (p >= field.pieces.size() || field.pieces[p].components.empty())
      throw Error(INSITU_ERROR_FIELD, name + ": piece " + std::to_string(p) + " has no values");
    const bool cells = field.association == INSITU_CELL;
    if (amr_ && !cells)
      throw Error(INSITU_ERROR_FIELD, name + ": on vertices; an adaptive mesh has values of cells "
                                             "(INSITU_CELL)");
    const std::int64_t expected = amr_    ? amr_pieces_[p].cell_count
                                  : cells ? pieces_[p].view.cell_count
                                          : vertices_of(pieces_[p]);
    if (field.pieces[p].layout.count != expected)
      throw Error(INSITU_ERROR_FIELD,
                  name + ", piece " + std::to_string(p) + ": " +
                      std::to_string(field.pieces[p].layout.count) + " values for " +
                      std::to_string(expected) + (cells ? " cells" : " vertices") +
                      (amr_ ? amr_pieces_[p].is_patch ? " of the patch; insitu_mesh_patch says "
                                                        "where it lies after a regrid"
                                                      : " of the leaves; insitu_mesh_leaves says "
                                                        "which they are after a regrid"
                            : ""));
  }
}

bool Mesh::lies_on_device() const {
  bool on_device = false;
  visit_arrays([&](const ExternalArray& array, const std::string&, ArrayKind) {
    on_device = on_device || array.memory == INSITU_DEVICE;
  });
  return on_device;
}

void Mesh::update(const core::Threads* threads) {
  if (amr_) {
    update_adaptive(threads);
    return;
  }
  for (std::size_t p = 0; p < pieces_.size(); ++p)
    check_piece(p);
  update_flat(threads);
  check_global_ids(threads);
  piece_views_.clear();
  first_cell_.assign(1, 0);
  first_vertex_.assign(1, 0);
  for (const Piece& p : pieces_) {
    // Before anything is done to each of them, and before sums could overflow.
    if (p.view.cell_count > most_cells - first_cell_.back())
      throw Error(INSITU_ERROR_UNSUPPORTED,
                  "mesh '" + name_ + "', piece " + std::to_string(piece_views_.size()) + ": " +
                      std::to_string(p.view.cell_count) + " cells after the " +
                      std::to_string(first_cell_.back()) +
                      " of the pieces before; a mesh holds at "
                      "most " +
                      std::to_string(most_cells));
    PieceView& view = piece_views_.emplace_back(p.view.cell_count == 0 ? PieceView{}
                                                : p.flat               ? p.flat->view()
                                                                       : p.view);
    if (p.view.cell_count > 0 && !p.flat)
      view.vertex_count = vertices_of(p);
    if (p.left_out)
      p.left_out->put_in(view);
    first_cell_.push_back(first_cell_.back() + p.view.cell_count);
    first_vertex_.push_back(first_vertex_.back() + piece_views_.back().vertex_count);
  }
  for (std::size_t p = 0; p < pieces_.size() && (pending_ & INSITU_CHANGED_TOPOLOGY); ++p)
    count_rings(p);
  add_halo();
  update_fields(threads);
  set_views();
}

void Mesh::add_halo() {
  for (const PieceView& piece : halo_ ? halo_->pieces() : std::span<const PieceView>()) {
    piece_views_.push_back(piece);
    first_cell_.push_back(first_cell_.back() + piece.cell_count);
    first_vertex_.push_back(first_vertex_.back() + piece.vertex_count);
  }
  if (first_cell_.back() > most_cells)
    throw Error(INSITU_ERROR_UNSUPPORTED,
                "mesh '" + name_ + "': " + std::to_string(first_cell_.back()) +
                    " cells with those of other processes that touch them; a mesh holds at most " +
                    std::to_string(most_cells));
}

void Mesh::set_views() {
  view_.pieces = piece_views_.data();
  view_.first_cell = first_cell_.data();
  view_.first_vertex = first_vertex_.data();
  view_.piece_count = std::int32_t(piece_views_.size());
  view_.halo_piece_count = std::int32_t(piece_views_.size() - pieces_.size());
  view_.join_pieces = !separate_pieces_;
  view_.is_flat = has_flat_pieces_;
  view_.plane = has_flat_pieces_ ? slab_.plane : 0.0;
  if (amr_)
    view_.set_plane(amr_->lattice);
  hide_earlier(); // of cells that may be others by now, until they are shown again
}

namespace {

bool axes_are_within(const PieceView& block, double bound) {
  bool within = true;
  for (int a = 0; a < 3; ++a) {
    if (!block.axis[a])
      within &= std::abs(block.block_coordinate(a, 0)) < bound &&
                std::abs(block.block_coordinate(a, block.block_vertices[a] - 1)) < bound;
    for (std::int64_t i = 0; block.axis[a] && i < block.block_vertices[a]; ++i)
      within &= std::abs(load_real(block.axis[a] + i * block.axis_stride[a],
                                   block.axis_is_float32)) < bound;
  }
  return within;
}

} // namespace

bool Mesh::vertices_are_within(double bound, const core::Threads& threads) const {
  constexpr std::int64_t few = 256;
  const MeshView& mesh = view();
  std::atomic<bool> all{true};
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const PieceView& piece = mesh.pieces[p];
    if (piece.implicit_points) {
      all = all && axes_are_within(piece, bound);
      continue;
    }
    threads.parallel_for(piece.vertex_count, 1 << 14, [&](std::int64_t begin, std::int64_t end) {
      math::Vec3d x[few];
      bool within = true;
      for (std::int64_t from = begin; from < end; from += few) {
        const std::int64_t n = std::min(few, end - from);
        copy_points(piece, from, from + n, x);
        for (std::int64_t i = 0; i < n; ++i)
          within &= bool(int(std::abs(x[i].x) < bound) & int(std::abs(x[i].y) < bound) &
                         int(std::abs(x[i].z) < bound));
      }
      if (!within)
        all = false;
    });
  }
  return all;
}

void Mesh::update_fields(const core::Threads* threads) {
  for (const auto& field : fields_) {
    check_field(*field);
    check_pointers(*field, threads);
    field->pieces.resize(pieces_.size());
    field->views.clear();
    for (std::size_t i = 0; i < pieces_.size(); ++i)
      if (first_cell_[i + 1] == first_cell_[i])
        field->views.push_back({no_values, {}, false, nullptr});
      else {
        add_view(*field, i, threads);
        if (pieces_[i].flat && field->association == INSITU_VERTEX)
          add_flat_view(field->pieces[i], i, field->components, field->views.back(), threads);
      }
    for (std::size_t i = 0; halo_ && i < halo_->pieces().size(); ++i)
      field->views.push_back(halo_->values(field->name, i));
  }
}

namespace {

std::string piece_name(std::size_t p) {
  return "piece " + std::to_string(p) + " ";
}

/// Arrays of one thing: one, or one a component.
void visit_components(const std::vector<ExternalArray>& arrays, const std::string& name,
                      Mesh::ArrayKind kind, Mesh::ArrayVisitor visit) {
  for (std::size_t i = 0; i < arrays.size(); ++i)
    visit(arrays[i], arrays.size() == 1 ? name : name + " component " + std::to_string(i), kind);
}

} // namespace

void Mesh::visit_field_piece(const Field& field, std::size_t p, ArrayVisitor visit) {
  if (p < field.pieces.size())
    visit_components(field.pieces[p].arrays, piece_name(p) + "field '" + field.name + "'",
                     ArrayKind::field, visit);
}

void Mesh::visit_field_arrays(const std::string& name, ArrayVisitor visit) const {
  if (const Field* field = find(name))
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      visit_field_piece(*field, p, visit);
}

void Mesh::visit_piece_fields(std::int32_t piece, ArrayVisitor visit) const {
  for (const auto& field : fields_)
    visit_field_piece(*field, std::size_t(piece), visit);
}

void Mesh::visit_arrays(ArrayVisitor visit) const {
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const std::string piece = piece_name(p);
    const Piece& from = pieces_[p];
    if (from.has_cells && from.view.cell_count == 0) // nobody reads them
      continue;
    visit_components(from.points, piece + "points", ArrayKind::geometry, visit);
    const std::pair<const ExternalArray*, const char*> cells[] = {
        {&from.connectivity, "connectivity"},
        {&from.types, "types"},
        {&from.offsets, "offsets"},
        {&from.ghosts, "ghosts"},
        {&from.hidden_points, "hidden points"},
        {&from.global_ids[INSITU_VERTEX], "global ids of vertices"},
        {&from.global_ids[INSITU_CELL], "global ids of cells"},
        {&from.amr.levels, "levels"},
        {&from.amr.corners, "corners"}};
    for (const auto& [array, name] : cells)
      if (array->given())
        visit(*array, piece + name, ArrayKind::topology);
    for (const auto& [array, name] : from.face_arrays)
      visit(array, piece + name, ArrayKind::topology);
    for (int a = 0; a < 3; ++a)
      if (from.axes[a].given())
        visit(from.axes[a], piece + "axis " + std::to_string(a), ArrayKind::geometry);
    visit_piece_fields(std::int32_t(p), visit);
  }
}

std::vector<insitu_audit_entry> Mesh::audit() const {
  std::vector<insitu_audit_entry> entries;
  visit_arrays([&](const ExternalArray& array, const std::string& name, ArrayKind) {
    insitu_audit_entry e{};
    e.size = sizeof e;
    std::strncpy(e.name, name.c_str(), sizeof e.name - 1);
    std::strncpy(e.reason, array.converted.c_str(), sizeof e.reason - 1);
    e.data = array.data;
    e.bytes = array.bytes();
    e.borrowed = array.converted.empty();
    entries.push_back(e);
  });
  audit_blanks(entries);
  return entries;
}

std::int64_t Mesh::bytes_borrowed() const {
  std::int64_t sum = 0;
  visit_arrays([&](const ExternalArray& array, const std::string&, ArrayKind) {
    if (array.converted.empty())
      sum += array.bytes();
  });
  return sum;
}

} // namespace insitu::mesh

/// Flat meshes, whose cells are given a thickness, and cells of lower dimension than others.
#include <algorithm>
#include <cstdio>

#include "core/status.h"
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

using core::Error;

namespace {

/// What the cells of a mixed piece are that are there.
struct Types {
  std::int64_t volumes = 0, surfaces = 0, lower = 0; ///< lower: lines and vertices
};

Types types_of(const PieceView& piece) {
  std::int64_t by_type[256] = {};
  for (std::int64_t c = 0; c < piece.cell_count; ++c)
    if (piece.exists(c)) // others may hold anything
      ++by_type[load_as<std::uint8_t>(piece.types + c * piece.types_stride)];
  Types out;
  for (int t = 0; t < 256; ++t)
    (is_below_area(t) ? out.lower : is_below_volume(t) ? out.surfaces : out.volumes) += by_type[t];
  return out;
}

} // namespace

/// Tells which pieces are flat, where cells may be others, and which cells are left out.
void Mesh::find_flat_pieces(const core::Threads* threads) {
  std::ptrdiff_t volume = -1, flat = -1; // the last such piece that is not mixed
  std::vector<Types> types(pieces_.size());
  bool any_volumes = false;
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    Piece& piece = pieces_[p];
    piece.left_out.reset();
    if (piece.view.cell_count == 0)
      continue;
    const bool is_mixed = !piece.is_block && piece.view.layout == CellLayout::mixed;
    if (is_mixed && piece.types.memory == INSITU_HOST)
      types[p] = types_of(piece.view);
    else if (is_mixed || !piece.flat_cells)
      types[p].volumes = piece.view.cell_count;
    if (!is_mixed)
      (piece.flat_cells ? flat : volume) = std::ptrdiff_t(p);
    any_volumes |= types[p].volumes > 0;
    if (types[p].volumes > 0)
      volume = std::ptrdiff_t(p);
  }
  has_flat_pieces_ = false;
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    Piece& piece = pieces_[p];
    if (piece.view.cell_count == 0)
      continue;
    const std::string name = "mesh '" + name_ + "', piece " + std::to_string(p);
    if (!piece.is_block && piece.view.layout == CellLayout::mixed) {
      const bool is_flat = !any_volumes && types[p].surfaces > 0;
      piece.flat_cells = is_flat ? FlatCells{FlatCells::Kind::mixed, 0} : FlatCells{};
      if (types[p].lower + (is_flat ? 0 : types[p].surfaces) > 0) {
        piece.left_out = std::make_shared<LeftOutCells>(*memory_);
        piece.left_out->make(piece.view, is_flat ? is_below_area : is_below_volume, threads);
      }
    }
    if (piece.flat_cells && any_volumes)
      throw Error(INSITU_ERROR_MESH, name + ": has flat cells, but piece " +
                                         std::to_string(volume) +
                                         " has volume cells; a mesh of one kind expected, or "
                                         "cells of several kinds in the mixed layout");
    if (!piece.flat_cells)
      piece.flat.reset();
    has_flat_pieces_ |= bool(piece.flat_cells);
    const bool all_left_out = types[p].volumes + types[p].surfaces == 0 && piece.left_out;
    if (!piece.flat_cells && !all_left_out && !piece.view.implicit_points &&
        piece.point_components == 2)
      throw Error(INSITU_ERROR_MESH,
                  name + ": 2 coordinates a vertex, 3 expected of cells that are not flat");
  }
  flat_facts_ = {};
  flat_facts_.volumes = any_volumes;
}

/// Makes the volume cells of flat pieces. Which pieces are flat, and what their vertices tell, is
/// found when cells or vertices may be others.
void Mesh::update_flat(const core::Threads* threads) {
  const bool others = (pending_ & INSITU_CHANGED_TOPOLOGY) != 0 || flat_is_stale_;
  if (others)
    find_flat_pieces(threads);
  if (!has_flat_pieces_)
    return;
  if (lies_on_device())
    throw Error(INSITU_ERROR_UNSUPPORTED,
                "mesh '" + name_ + "' is flat: its arrays are read in host memory");
  const auto source = [&](const Piece& piece) {
    return FlatSource(piece.view, piece.flat_cells, vertices_of(piece),
                      !piece.is_block || !piece.view.implicit_points ? piece.point_components == 3
                                                                     : false,
                      flat_turn_);
  };
  const bool moved = others || (pending_ & INSITU_CHANGED_GEOMETRY) != 0;
  if (moved) {
    FlatFacts found;
    found.volumes = flat_facts_.volumes;
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      if (pieces_[p].flat_cells && pieces_[p].view.cell_count > 0) {
        const std::string name = "mesh '" + name_ + "', piece " + std::to_string(p);
        source(pieces_[p]).look(name, threads, found);
        source(pieces_[p]).require_plane(name, found);
      }
    flat_facts_ = found;
  }
  const FlatSlab slab = FlatSlab::of(whole_flat_ ? *whole_flat_ : flat_facts_);
  const bool elsewhere = !(slab == slab_);
  slab_ = slab;
  for (Piece& piece : pieces_) {
    if (!piece.flat_cells || piece.view.cell_count == 0)
      continue;
    const bool lacks = !piece.flat;
    if (lacks)
      piece.flat = std::make_shared<FlatPiece>(*memory_);
    if (lacks || moved || elsewhere)
      piece.flat->make(source(piece), slab_, lacks || others, threads);
  }
  flat_is_stale_ = false;
}

std::int64_t Mesh::solver_vertex_count() const {
  std::int64_t sum = 0;
  for (std::size_t p = 0; p < pieces_.size(); ++p)
    sum += piece_views_[p].flat_vertices > 0 ? piece_views_[p].flat_vertices
                                             : piece_views_[p].vertex_count;
  return sum;
}

std::string Mesh::left_out() const {
  std::array<std::int64_t, 3> counts{};
  for (const Piece& piece : pieces_)
    for (std::size_t k = 0; piece.left_out && k < counts.size(); ++k)
      counts[k] += piece.left_out->counts()[k];
  std::string text;
  const char* const names[] = {"vertices", "lines", "triangles, quads and other surfaces"};
  for (std::size_t k = counts.size(); k-- > 0;)
    if (counts[k] > 0)
      text += (text.empty() ? "" : ", ") + std::to_string(counts[k]) + " " + names[k];
  return text.empty()
             ? text
             : "mesh '" + name_ + "': cells of lower dimension than others are left out: " + text;
}

void Mesh::audit_flat(std::vector<insitu_audit_entry>& entries) const {
  const auto add = [&](std::size_t p, const char* what, const char* why, std::int64_t bytes) {
    insitu_audit_entry e{};
    e.size = sizeof e;
    std::snprintf(e.name, sizeof e.name, "piece %zu %s", p, what);
    std::snprintf(e.reason, sizeof e.reason, "%s", why);
    e.bytes = bytes;
    entries.push_back(e);
  };
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    if (pieces_[p].flat && pieces_[p].flat->bytes() > 0)
      add(p, "flat cells as volume cells", "a flat mesh is located with a thickness",
          pieces_[p].flat->bytes());
    if (pieces_[p].left_out)
      add(p, "cells left out", "their dimension is lower than that of others",
          pieces_[p].left_out->bytes());
  }
}

/// Gives a vertex both values of its two: the same. Where the items do not lie in one row, or in
/// rows of one layer, a copy does.
void Mesh::add_flat_view(FieldPiece& piece, std::size_t p, int components, FieldPieceView& view,
                         const core::Threads* threads) const {
  const std::int64_t n = piece_views_[p].flat_vertices;
  const bool in_rows =
      !view.behind && (view.layout.linear || view.layout.extent[0] * view.layout.extent[1] == n);
  if (in_rows) {
    piece.in_rows.reset();
  } else {
    if (!piece.in_rows)
      piece.in_rows = std::make_shared<BlankedValues>(*memory_, INSITU_MEMORY_FLAT);
    piece.in_rows->make(view, components, {}, nullptr, {}, threads);
    const BlankedValues& copy = *piece.in_rows;
    view = {copy.components().data(), copy.layout(), copy.is_float32(), nullptr};
  }
  ItemLayout& layout = view.layout;
  if (layout.linear) {
    layout.extent[0] = n;
    layout.extent[1] = 1;
    layout.stride[1] = 0;
  }
  layout.stride[2] = 0;
  layout.count = 2 * n;
  layout.linear = false;
}

} // namespace insitu::mesh

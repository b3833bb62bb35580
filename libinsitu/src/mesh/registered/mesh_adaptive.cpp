/// Adaptive meshes: registration, and the view of it.
#include <algorithm>

#include "core/status.h"
#include "mesh/registered/mesh.h"

namespace insitu::mesh {

using core::Error;

namespace {

std::string name_of(const std::string& mesh, std::size_t piece) {
  return "mesh '" + mesh + "', piece " + std::to_string(piece);
}

} // namespace

void Mesh::refuse_if_adaptive(const std::string& name) const {
  if (amr_)
    throw Error(INSITU_ERROR_ORDER, name + ": the mesh is adaptive (insitu_mesh_amr); its pieces "
                                           "are given by insitu_mesh_patch or insitu_mesh_leaves");
}

const AmrLevels& Mesh::levels_for(const std::string& name) const {
  if (!amr_)
    throw Error(INSITU_ERROR_ORDER,
                name + ": the mesh is not adaptive; call insitu_mesh_amr first");
  return *amr_;
}

void Mesh::set_amr(const insitu_amr* amr) {
  const std::string name = "mesh '" + name_ + "' levels";
  const AmrLevels levels = adopt_levels(amr, name);
  for (std::size_t p = 0; p < pieces_.size(); ++p)
    if (pieces_[p].has_cells || pieces_[p].has_points || pieces_[p].ghosts.given())
      throw Error(INSITU_ERROR_ORDER,
                  name + ": piece " + std::to_string(p) + " has " +
                      (pieces_[p].has_cells    ? pieces_[p].is_block ? "a block" : "cells"
                       : pieces_[p].has_points ? "points"
                                               : "ghosts") +
                      " already; the pieces of an adaptive mesh are patches or leaves alone");
  if (amr_ && amr_->dimensions() != levels.dimensions() && !pieces_.empty())
    throw Error(INSITU_ERROR_ORDER, name + ": dimensions " + std::to_string(levels.dimensions()) +
                                        ", but the pieces were given with " +
                                        std::to_string(amr_->dimensions()) +
                                        "; drop them first (insitu_mesh_drop_pieces)");
  // Samples by another rule need no other structure.
  pending_ |= amr_ && amr_->same_cells(levels) ? INSITU_CHANGED_FIELDS : INSITU_CHANGED_ALL;
  amr_ = levels;
}

void Mesh::set_patch(std::int32_t piece, const insitu_patch* patch) {
  const std::string name = "mesh '" + name_ + "', piece " + std::to_string(piece) + " patch";
  const AmrLevels& levels = levels_for(name);
  const bool is_flat = levels.lattice.is_flat != 0;
  const bool no_cells =
      patch && *std::min_element(patch->cells, patch->cells + levels.dimensions()) == 0;
  AmrPiece adopted;
  if (no_cells)
    adopted.kind = AmrPiece::Kind::leaves; // none of them
  else
    adopted = adopt_patch(patch, is_flat, name);
  (void)view_of(adopted, levels, name); // throws if it does not fit
  piece_for(piece).amr = std::move(adopted);
  pending_ |= INSITU_CHANGED_ALL;
}

void Mesh::set_leaves(std::int32_t piece, const insitu_leaves* leaves) {
  const std::string name = "mesh '" + name_ + "', piece " + std::to_string(piece) + " leaves";
  AmrPiece adopted = adopt_leaves(leaves, levels_for(name).lattice.is_flat != 0, name);
  piece_for(piece).amr = std::move(adopted);
  pending_ |= INSITU_CHANGED_ALL;
}

void Mesh::set_separate_pieces(bool separate) {
  if (separate_pieces_ != separate)
    pending_ |= INSITU_CHANGED_GEOMETRY;
  separate_pieces_ = separate;
}

void Mesh::drop_pieces(std::int32_t first) {
  if (first < 0 || std::size_t(first) > pieces_.size())
    throw Error(INSITU_ERROR_ARGUMENT, "mesh '" + name_ + "': drops pieces from " +
                                           std::to_string(first) + " on, 0 to " +
                                           std::to_string(pieces_.size()) + " expected");
  if (std::size_t(first) == pieces_.size())
    return;
  const auto count = std::size_t(first);
  pieces_.erase(pieces_.begin() + first, pieces_.end());
  for (const auto& field : fields_)
    if (field->pieces.size() > count)
      field->pieces.erase(field->pieces.begin() + first, field->pieces.end());
  pending_ |= INSITU_CHANGED_ALL;
}

int Mesh::level_of(std::int32_t piece, std::int64_t cell) const {
  const AmrPieceView& view = amr_pieces_[std::size_t(piece)];
  return view.is_patch ? pieces_[std::size_t(piece)].amr.patch.level : int(view.raw_level(cell));
}

void Mesh::update_adaptive(const core::Threads* threads) {
  std::vector<AmrPieceView> views;
  std::vector<std::int64_t> first{0};
  for (std::size_t p = 0; p < pieces_.size(); ++p) {
    const std::string name = name_of(name_, p);
    const AmrPiece& piece = pieces_[p].amr;
    if (piece.kind == AmrPiece::Kind::none)
      throw Error(INSITU_ERROR_ORDER, name + ": has no cells; call insitu_mesh_patch or "
                                             "insitu_mesh_leaves first");
    views.push_back(view_of(piece, *amr_, name));
    // Before anything is done to each of them, and before sums could overflow.
    if (views.back().cell_count > most_cells - first.back())
      throw Error(INSITU_ERROR_UNSUPPORTED, name + ": " + std::to_string(views.back().cell_count) +
                                                " cells after the " + std::to_string(first.back()) +
                                                " of the pieces before; a mesh holds at " +
                                                "most " + std::to_string(most_cells));
    first.push_back(first.back() + views.back().cell_count);
  }
  if (pending_ & INSITU_CHANGED_TOPOLOGY)
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      check_leaves(pieces_[p].amr, views[p], *amr_, name_of(name_, p), threads);

  for (const AmrPieceView& leaves : halo_ ? halo_->leaves() : std::span<const AmrPieceView>()) {
    views.push_back(leaves);
    first.push_back(first.back() + leaves.cell_count);
  }
  amr_pieces_ = std::move(views);
  first_cell_ = std::move(first);
  check_global_ids(threads);
  for (const auto& field : fields_)
    for (const FieldPiece& piece : field->pieces)
      for (const ExternalArray& array : piece.arrays)
        if (array.memory != INSITU_HOST)
          throw Error(INSITU_ERROR_UNSUPPORTED,
                      "mesh '" + name_ + "', field '" + field->name +
                          "': in device memory; an adaptive mesh is read on the host");
  update_fields(threads);
  for (const auto& field : fields_)
    for (std::size_t p = 0; p < pieces_.size(); ++p)
      for (const ExternalArray& array : field->pieces[p].arrays)
        if (amr_pieces_[p].ghost_faces != 0)
          if (const std::string why = why_no_ghosts(pieces_[p].amr.patch, array); !why.empty())
            throw Error(INSITU_ERROR_FIELD,
                        name_of(name_, p) + ", field '" + field->name + "': " + why);

  amr_view_.lattice = amr_->lattice;
  flat_facts_ = amr_->flat_facts();
  amr_view_.level_count = amr_->level_count;
  amr_view_.finest_first = amr_->finest_first;
  std::copy(amr_->depth_of, amr_->depth_of + AmrView::most_levels, amr_view_.depth_of);
  amr_view_.pieces = amr_pieces_.data();
  amr_view_.first_cell = first_cell_.data();
  amr_view_.piece_count = std::int32_t(amr_pieces_.size());
  amr_view_.halo_piece_count = std::int32_t(amr_pieces_.size() - pieces_.size());
  amr_view_.far_piece_count = halo_ ? halo_->far_count() : 0;
  amr_view_.covered = halo_ ? halo_->covered() : nullptr;
  make_leaves_views();
}

/// Its cells as voxels.
void Mesh::make_leaves_views() {
  if (pending_ & INSITU_CHANGED_TOPOLOGY)
    masked_ = nullptr; // other cells
  leaves_views_.clear();
  piece_views_.clear();
  first_vertex_.assign(1, 0);
  for (std::size_t p = 0; p < amr_pieces_.size(); ++p)
    leaves_views_.push_back({&amr_view_, std::int32_t(p), masked_});
  for (std::size_t p = 0; p < amr_pieces_.size(); ++p) {
    PieceView& view = piece_views_.emplace_back();
    view.layout = CellLayout::leaves;
    view.uniform_shape = Shape::voxel;
    view.cell_count = amr_pieces_[p].cell_count;
    view.vertex_count = 8 * view.cell_count;
    view.leaves = &leaves_views_[p];
    view.is_halo = amr_pieces_[p].rank >= 0;
    first_vertex_.push_back(first_vertex_.back() + view.vertex_count);
  }
  set_views();
}

void Mesh::set_masked(const std::uint64_t* masked) {
  masked_ = masked;
  for (LeavesView& leaves : leaves_views_)
    leaves.masked = masked;
}

void Mesh::check_pointers(Field& field, const core::Threads* threads) const {
  for (std::size_t p = 0; p < field.pieces.size(); ++p) {
    FieldPiece& piece = field.pieces[p];
    if (piece.behind.empty() || first_cell_[p + 1] == first_cell_[p] ||
        (piece.pointers_checked && !(pending_ & INSITU_CHANGED_TOPOLOGY)))
      continue;
    for (const ExternalArray& array : piece.arrays) {
      const std::int64_t bad = first_bad(array.layout.count, threads, [&](std::int64_t i) {
        return !load_as<const std::byte*>(array.data + array.layout.offset(i));
      });
      if (bad < array.layout.count)
        throw Error(INSITU_ERROR_FIELD, "mesh '" + name_ + "', field '" + field.name + "', piece " +
                                            std::to_string(p) + ": the pointer of item " +
                                            std::to_string(bad) + " is null");
    }
    piece.pointers_checked = true;
  }
}

} // namespace insitu::mesh

/// The entry points of insitu/c/amr.h.
#include "api/entry.h"

using namespace insitu;
using api::with_asked_mesh;
using api::with_mesh;

extern "C" {

insitu_status insitu_mesh_amr(insitu_mesh mesh, const insitu_amr* amr) {
  return with_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) { m.mesh().set_amr(amr); });
}

insitu_status insitu_mesh_patch(insitu_mesh mesh, int32_t piece, const insitu_patch* patch) {
  return with_mesh(
      mesh, [&](api::Session&, commit::CommittedMesh& m) { m.mesh().set_patch(piece, patch); });
}

insitu_status insitu_mesh_leaves(insitu_mesh mesh, int32_t piece, const insitu_leaves* leaves) {
  return with_mesh(
      mesh, [&](api::Session&, commit::CommittedMesh& m) { m.mesh().set_leaves(piece, leaves); });
}

insitu_status insitu_mesh_cell_levels(insitu_mesh mesh, int64_t count, const int64_t* cells,
                                      const int32_t* pieces, int64_t cell_base, int32_t* levels) {
  return with_asked_mesh(mesh, [&](api::Session&, commit::CommittedMesh& m) {
    const mesh::Mesh& own = m.mesh();
    const std::string name = "mesh '" + own.name() + "', levels of cells: ";
    m.require_committed();
    if (!own.is_adaptive())
      throw core::Error(INSITU_ERROR_ORDER, name + "it is not an adaptive mesh");
    if (count < 0 || cell_base < 0 || cell_base > 1)
      throw core::Error(INSITU_ERROR_ARGUMENT, name + std::to_string(count) + " cells from " +
                                                   std::to_string(cell_base) +
                                                   " on; 0 or more from 0 or 1 on expected");
    if (count > 0) {
      api::require(cells, "cells");
      api::require(levels, "levels");
    }
    const mesh::AmrView& view = own.adaptive();
    if (!pieces && view.piece_count != 1 && count > 0)
      throw core::Error(INSITU_ERROR_ARGUMENT,
                        name + "pieces: null, of a mesh of " + std::to_string(view.piece_count));
    for (std::int64_t i = 0; i < count; ++i) {
      const std::int32_t piece = pieces ? pieces[i] : 0;
      const std::int64_t cell = cells[i];
      if (piece == -1 || cell == cell_base - 1) {
        levels[i] = -1;
        continue;
      }
      const std::int64_t of_piece = piece >= 0 && piece < view.piece_count
                                        ? view.first_cell[piece + 1] - view.first_cell[piece]
                                        : 0;
      if (cell < cell_base || cell - cell_base >= of_piece)
        throw core::Error(INSITU_ERROR_ARGUMENT, name + "item " + std::to_string(i) + " is cell " +
                                                     std::to_string(cell) + " of piece " +
                                                     std::to_string(piece) + ", which has " +
                                                     std::to_string(of_piece) + " cells");
      levels[i] = own.level_of(piece, cell - cell_base);
    }
  });
}

} // extern "C"

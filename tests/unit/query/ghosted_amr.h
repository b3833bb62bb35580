#pragma once

#include <limits>

#include "amr/leaves/leaf_map.h"
#include "unit/query/registered_amr.h"

namespace insitu::test {

/// A random adaptive mesh of patches (every leaf is one), whose fields have a layer of ghost cells
/// before and two after the cells, in Fortran and C order by turns. Ghosts hold values where no
/// cell of the mesh lies beyond a face; all others, and those beyond edges and corners, are NaN.
class GhostedAmr {
public:
  /// faces(p): those of piece p where its ghosts are to be used, a bit each (2 axis + side).
  template <class Faces, class F>
  GhostedAmr(const Recipe& recipe, Faces&& faces, F&& field) : amr(make_mesh(recipe)) {
    amr.give_ghosts();
    for (std::size_t p = 0; p < amr.pieces.size(); ++p)
      amr.pieces[p].ghost_faces = faces(p);
    const mesh::AmrView& view = amr.view();
    map.build(view, core::Threads(1));
    mesh::Mesh& mesh = committed.mesh.mesh();
    set_levels(mesh, view, INSITU_DUAL);
    values.resize(amr.pieces.size());
    for (std::size_t p = 0; p < amr.pieces.size(); ++p) {
      const AmrPiece& piece = amr.pieces[p];
      insitu_patch patch = insitu_patch_default();
      patch.level = piece.level;
      for (int a = 0; a < 3; ++a) {
        patch.lower[a] = piece.lower[std::size_t(a)];
        patch.cells[a] = piece.size[std::size_t(a)];
        patch.ghosts_before[a] = piece.ghost_faces >> (2 * a) & 1 ? 1 : 0;
        patch.ghosts_after[a] = piece.ghost_faces >> (2 * a) & 2 ? 2 : 0;
      }
      mesh.set_patch(std::int32_t(p), &patch);
      const Strides s(piece, p);
      values[p].assign(s.total, std::numeric_limits<double>::quiet_NaN());
      insitu_array array =
          insitu_array_of(values[p].data() + s.first, INSITU_FLOAT64, piece.cell_count(), 1);
      for (int a = 0; a < 3; ++a) {
        array.extent[a] = patch.cells[a];
        array.stride[a] = 8 * s.stride[a];
      }
      mesh.set_field(std::int32_t(p), "f", INSITU_CELL, &array, 1);
    }
    fill(field);
    committed.commit();
  }

  /// New values, for a commit of INSITU_CHANGED_FIELDS.
  template <class F>
  void fill(F&& field) {
    const mesh::AmrView& view = amr.view();
    for (std::size_t p = 0; p < amr.pieces.size(); ++p) {
      const AmrPiece& piece = amr.pieces[p];
      const Strides s(piece, p);
      Index n;
      for (n[2] = -1; n[2] <= piece.size[2]; ++n[2])
        for (n[1] = -1; n[1] <= piece.size[1]; ++n[1])
          for (n[0] = -1; n[0] <= piece.size[0]; ++n[0]) {
            mesh::AmrCell cell{view.pieces[p].depth, {}};
            std::int64_t at = s.first;
            int out = 0;
            for (std::size_t a = 0; a < 3; ++a) {
              cell.index[a] = piece.lower[a] + n[a];
              at += n[a] * s.stride[a];
              out += n[a] < 0 || n[a] == piece.size[a];
            }
            const bool has_cell =
                map.cover(cell.depth, cell.index) ||
                map.store().at(cell.depth, cell.index) == amr::BrickStore::refined;
            if (out == 0 || (out == 1 && !has_cell))
              values[p][std::size_t(at)] = field(RegisteredAmr::centre_of(view, cell));
          }
    }
  }

  AmrMesh amr;
  core::Memory memory;
  amr::LeafMap map{memory};
  std::vector<std::vector<double>> values;
  fixtures::Committed committed;

private:
  struct Strides {
    Strides(const AmrPiece& piece, std::size_t p) {
      std::int64_t next = 1;
      for (int i = 0; i < 3; ++i) {
        const int a = p % 2 ? 2 - i : i;
        stride[a] = next;
        first += next;
        next *= piece.size[std::size_t(a)] + 3;
      }
      total = std::size_t(next);
    }
    std::int64_t stride[3]; ///< in values
    std::int64_t first = 0; ///< the first cell
    std::size_t total;
  };
};

} // namespace insitu::test

#pragma once

#include <utility>

#include "fixtures/committed.h"
#include "unit/amr/amr_mesh.h"

namespace insitu::test {

inline void set_levels(mesh::Mesh& mesh, const mesh::AmrView& view,
                       insitu_reconstruction reconstruction) {
  insitu_amr levels = insitu_amr_default();
  for (int a = 0; a < 3; ++a) {
    levels.origin[a] = view.lattice.origin[a];
    levels.spacing[a] = view.lattice.spacing[a];
  }
  levels.level_count = view.level_count;
  std::vector<std::int32_t> ratios;
  for (int l = 1; l < view.level_count; ++l)
    ratios.push_back(1 << (view.depth_of[l] - view.depth_of[l - 1]));
  levels.ratios = ratios.data();
  levels.reconstruction = reconstruction;
  mesh.set_amr(&levels);
}

/// An adaptive mesh, a random one for instance, handed over and committed, with a field of cells.
class RegisteredAmr {
public:
  template <class F>
  RegisteredAmr(const Recipe& recipe, insitu_reconstruction reconstruction, F&& field,
                int thread_limit = 0)
      : RegisteredAmr(make_mesh(recipe), reconstruction, field, thread_limit) {}
  template <class F>
  RegisteredAmr(AmrMesh mesh_given, insitu_reconstruction reconstruction, F&& field,
                int thread_limit = 0)
      : amr(std::move(mesh_given)), committed(thread_limit) {
    const mesh::AmrView& view = amr.view();
    mesh::Mesh& mesh = committed.mesh.mesh();
    set_levels(mesh, view, reconstruction);
    corners.resize(amr.pieces.size());
    values.resize(amr.pieces.size());
    for (std::size_t p = 0; p < amr.pieces.size(); ++p) {
      const AmrPiece& piece = amr.pieces[p];
      const auto id = std::int32_t(p);
      const std::int64_t n = piece.cell_count();
      if (piece.is_patch) {
        insitu_patch patch = insitu_patch_default();
        patch.level = piece.level;
        std::copy(piece.lower.begin(), piece.lower.end(), patch.lower);
        std::copy(piece.size.begin(), piece.size.end(), patch.cells);
        mesh.set_patch(id, &patch);
      } else {
        for (const Index& c : piece.corners)
          corners[p].insert(corners[p].end(), c.begin(), c.end());
        insitu_leaves leaves = insitu_leaves_default();
        leaves.levels = insitu_array_of(piece.levels.data(), INSITU_INT32, n, 1);
        leaves.corners = insitu_array_of(corners[p].data(), INSITU_INT64, n, 3);
        mesh.set_leaves(id, &leaves);
      }
      for (std::int64_t c = 0; c < n; ++c)
        values[p].push_back(field(centre_of(view, view.cell(view.pieces[p], c))));
      const insitu_array array = insitu_array_of(values[p].data(), INSITU_FLOAT64, n, 1);
      mesh.set_field(id, "f", INSITU_CELL, &array, 1);
    }
    committed.commit();
  }

  static math::Vec3d centre_of(const mesh::AmrView& view, const mesh::AmrCell& cell) {
    math::Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = view.lattice.centre(a, cell.depth, cell.index[a]);
    return p;
  }

  AmrMesh amr;
  std::vector<std::vector<std::int64_t>> corners;
  std::vector<std::vector<double>> values;
  fixtures::Committed committed;
};

} // namespace insitu::test

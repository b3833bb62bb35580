#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <vector>

#include "core/memory.h"
#include "mesh/registered/mesh.h"
#include "unit/amr/amr_mesh.h"

/// Adaptive meshes over processes: patches and leaves dealt out.
namespace insitu::test {

/// Which process has a patch or a leaf. number: of patches and leaves, in their order; middle: in
/// cells of depth 0.
using Deal = std::function<int(std::size_t number, const math::Vec3d& middle)>;

/// What one process has of a mesh, with two fields and, unless without_ids(), global ids, which are
/// the numbers of cells in the whole mesh. Owns the arrays.
class AmrPart {
public:
  AmrPart(const AmrMesh& whole, insitu_reconstruction how, const Deal& deal, int rank) {
    amr_ = insitu_amr_default();
    for (std::size_t a = 0; a < 3; ++a) {
      amr_.origin[a] = whole.lattice.origin[a];
      amr_.spacing[a] = whole.lattice.spacing[a];
    }
    if (whole.lattice.is_flat != 0) {
      amr_.dimensions = 2;
      amr_.origin[2] = whole.lattice.plane;
    }
    amr_.level_count = std::int32_t(whole.depth_of.size());
    for (std::size_t l = 1; l < whole.depth_of.size(); ++l)
      ratios_.push_back(1 << (whole.depth_of[l] - whole.depth_of[l - 1]));
    amr_.ratios = ratios_.data();
    amr_.reconstruction = how;
    add(whole, deal, rank);
  }
  /// The pieces that the deal gives another process, behind those that are there.
  void add(const AmrMesh& whole, const Deal& deal, int rank) {
    std::int64_t first = 0;
    std::size_t number = 0;
    for (const AmrPiece& piece : whole.pieces) {
      const int depth = whole.depth_of[std::size_t(piece.is_patch ? piece.level : 0)];
      const auto middle = [&](int d, const Index& lower, const Index& size) {
        math::Vec3d m;
        for (std::size_t a = 0; a < 3; ++a)
          m[int(a)] = (double(lower[a]) + 0.5 * double(size[a])) / double(1 << d);
        return m;
      };
      Piece mine;
      mine.piece = piece;
      mine.piece.levels.clear();
      mine.piece.corners.clear();
      if (piece.is_patch) {
        if (deal(number++, middle(depth, piece.lower, piece.size)) == rank)
          for (std::int64_t c = 0; c < piece.cell_count(); ++c)
            mine.ids.push_back(first + c);
      } else {
        for (std::size_t c = 0; c < piece.levels.size(); ++c)
          if (deal(number++, middle(whole.depth_of[std::size_t(piece.levels[c])], piece.corners[c],
                                    {1, 1, 1})) == rank) {
            mine.piece.levels.push_back(piece.levels[c]);
            mine.piece.corners.push_back(piece.corners[c]);
            mine.ids.push_back(first + std::int64_t(c));
          }
      }
      first += piece.cell_count();
      if (!mine.ids.empty())
        pieces_.push_back(std::make_unique<Piece>(std::move(mine)));
    }
  }

  void without_ids() { has_ids_ = false; }
  bool empty() const { return pieces_.empty(); }

  void give(mesh::Mesh& to, double factor = 1.0) {
    to.set_amr(&amr_);
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      Piece& piece = *pieces_[p];
      const auto number = std::int32_t(p);
      const auto count = std::int64_t(piece.ids.size());
      if (piece.piece.is_patch) {
        insitu_patch patch = insitu_patch_default();
        patch.level = piece.piece.level;
        for (std::size_t a = 0; a < 3; ++a) {
          patch.lower[a] = piece.piece.lower[a];
          patch.cells[a] = piece.piece.size[a];
        }
        to.set_patch(number, &patch);
      } else {
        insitu_leaves leaves = insitu_leaves_default();
        leaves.levels = insitu_array_of(piece.piece.levels.data(), INSITU_INT32, count, 1);
        leaves.corners = insitu_array_of(piece.piece.corners.data(), INSITU_INT64, count, 3);
        to.set_leaves(number, &leaves);
      }
      const insitu_array ids = insitu_array_of(piece.ids.data(), INSITU_INT64, count, 1);
      if (has_ids_)
        to.set_global_ids(number, INSITU_CELL, &ids);
    }
    to.drop_pieces(std::int32_t(pieces_.size()));
    give_fields(to, factor);
  }
  void give_fields(mesh::Mesh& to, double factor) {
    for (std::size_t p = 0; p < pieces_.size(); ++p) {
      Piece& piece = *pieces_[p];
      const auto count = std::int64_t(piece.ids.size());
      piece.scalar.clear();
      piece.vector.clear();
      for (const std::int64_t id : piece.ids) {
        piece.scalar.push_back(float(factor * std::sin(1.7 * double(id))));
        for (int c = 0; c < 3; ++c)
          piece.vector.push_back(factor * std::cos(0.3 * double(id) + c));
      }
      const insitu_array s = insitu_array_of(piece.scalar.data(), INSITU_FLOAT32, count, 1);
      const insitu_array v = insitu_array_of(piece.vector.data(), INSITU_FLOAT64, count, 3);
      to.set_field(std::int32_t(p), "s", INSITU_CELL, &s, 1);
      to.set_field(std::int32_t(p), "v", INSITU_CELL, &v, 1);
    }
  }

private:
  struct Piece {
    AmrPiece piece;
    std::vector<std::int64_t> ids;
    std::vector<float> scalar;
    std::vector<double> vector;
  };
  std::vector<std::unique_ptr<Piece>> pieces_;
  std::vector<std::int32_t> ratios_;
  insitu_amr amr_;
  bool has_ids_ = true;
};

} // namespace insitu::test

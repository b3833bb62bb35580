#pragma once

#include <cstdint>

#include "amr/dual/cell_runs.h"
#include "amr/leaves/brick_store.h"
#include "math/vec.h"

namespace insitu::amr {

/// Faces of a cell are numbered 2 axis + side; ghost cells by the face that they lie across.
constexpr std::uint8_t no_ghost = 0xff;

/// Whether the fields of a leaf's patch hold the cell across that face as a ghost.
inline bool has_ghost(const mesh::AmrView& mesh, std::uint32_t leaf, int face) {
  const std::int32_t p = piece_of(mesh, leaf);
  const mesh::AmrPieceView& piece = mesh.pieces[p];
  if (piece.ghost_items)
    return piece.ghost_items[6 * (leaf - mesh.first_cell[p]) + face] >= 0;
  return piece.ghost_faces >> face & 1 &&
         piece.is_at_face(mesh.cell(piece, leaf - mesh.first_cell[p]), face);
}

/// A field's gradient in a leaf, linear in values: the least squares fit to the leaves across its
/// faces (of finer ones, the four nearest to the middle of the face), and, where the domain ends,
/// to the solver's ghost cells. Linear fields are met exactly. Along an axis that all these do not
/// span it is zero: the leaf has no neighbour there, or only much finer ones across other faces,
/// whose differences would be blown up.
class LeafGradient {
public:
  struct Neighbor {
    std::uint32_t id;   ///< the leaf; of a ghost cell, the leaf beside it
    std::uint8_t ghost; ///< the face that it lies across, or no_ghost
    math::Vec3d offset; ///< of its centre, in cells of the leaf
    double weight;
  };

  LeafGradient() = default;
  LeafGradient(const BrickStore& store, const mesh::AmrView& mesh, std::uint32_t id,
               const mesh::AmrCell& leaf);

  int count() const { return count_; }
  const Neighbor& operator[](int n) const { return list_[n]; }
  /// Whether something lies across every face.
  bool is_enclosed() const { return enclosed_; }

  /// terms[n], times the difference of neighbour n's value to the leaf's, add up to the gradient,
  /// in cells of the leaf.
  static constexpr int most_terms = 24;
  void fit(math::Vec3d* terms) const;

private:
  void add(std::uint32_t id, std::uint8_t ghost, int depth, const std::int64_t* index);
  void across(const BrickStore& store, const mesh::AmrView& mesh, int axis, int side);
  void descend(const BrickStore& store, int axis, int side, int quarter, const std::int64_t* from);

  std::uint32_t id_ = 0;
  mesh::AmrCell leaf_;
  Neighbor list_[most_terms];
  int count_ = 0;
  int axes_ = 3; ///< of a flat mesh 2
  bool enclosed_ = true;
};

} // namespace insitu::amr

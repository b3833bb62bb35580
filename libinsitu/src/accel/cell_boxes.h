#pragma once

#include "accel/node.h"
#include "mesh/view.h"

namespace insitu::accel {

/// Computes cell boxes in a local frame, outwards. The choice among number types is made once, at
/// construction, for pieces of one shape over evenly spaced arrays; others take the general way.
class CellBoxes {
public:
  CellBoxes(const mesh::MeshView& mesh, const math::Vec3d& origin);

  /// The box of a flat cell; a box with lower = +infinity if a coordinate is not finite or too large
  /// for a float.
  Box operator()(std::int64_t flat_cell) const {
    if (fast_)
      return fast_(mesh_->pieces[0], flat_cell, origin_);
    return general(flat_cell);
  }
  static bool is_finite(const Box& b) { return b.lower[0] < std::numeric_limits<float>::max(); }

private:
  using Function = Box (*)(const mesh::PieceView&, std::int64_t, const math::Vec3d&);
  Box general(std::int64_t flat_cell) const;

  const mesh::MeshView* mesh_;
  math::Vec3d origin_;
  Function fast_ = nullptr;
};

} // namespace insitu::accel

#pragma once

#include "accel/node.h"
#include "mesh/view.h"

namespace insitu::accel {

/// Computes cell boxes in a local frame, outwards. The choice among number types and array layouts
/// is made once, at construction, for pieces of one shape over evenly spaced arrays; others take
/// the general way.
class CellBoxes {
public:
  CellBoxes(const mesh::MeshView& mesh, const math::Vec3d& origin);

  /// The boxes of n flat cells. Returns the lowest of the cells with a coordinate that is not
  /// finite or too large for a float (its box is empty), or -1.
  std::int64_t compute(const std::uint32_t* flat_cells, std::uint32_t n, Box* boxes) const;

  /// What the loops over pieces of one shape need. padded: the last vertex and a fourth number, so
  /// that four can be loaded at any vertex without reading past the solver's array.
  struct Arrays {
    const std::byte* ids = nullptr;
    std::int64_t cell_stride = 0, id_stride = 0, base = 0;
    const std::byte* component[3] = {};
    std::int64_t point_stride = 0, last = 0;
    alignas(32) double padded[4] = {};
    int count = 0;
    math::Vec3d origin;
  };
  using Loop = std::int64_t (*)(const Arrays&, const std::uint32_t*, std::uint32_t, Box*);

private:
  const mesh::MeshView* mesh_;
  Arrays arrays_;
  Loop loop_ = nullptr;
};

} // namespace insitu::accel

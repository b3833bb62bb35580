#pragma once

#include <cstdint>

#include "cells/kernels/cell_block.h"

/// Kernels over blocks of (cell, point) pairs, compiled per SIMD target and dispatched at run time.
namespace insitu::query {

/// (cell, point) pairs, the cells of one shape.
struct PairBlock {
  static constexpr int row = cells::CellBlock::row;
  cells::CellBlock cells; ///< as many as points
  alignas(64) double point[3][row];
  alignas(64) double parametric[3][row]; ///< by invert
  alignas(64) double margin[row];        ///< by invert; see cells::InverseMap
  alignas(64) double error[row];         ///< by invert; see cells::InverseMap
  // By invert; bit k is pair k's.
  std::uint64_t converged;
  std::uint64_t certified;       ///< the point is proven inside: margin > error
  std::uint64_t on_boundary;     ///< see cells::is_on_boundary
  std::uint64_t inside, outside; ///< by contain: proven; neither: undecided

  math::Vec3d point_of(int k) const { return {point[0][k], point[1][k], point[2][k]}; }
  math::Vec3d parametric_of(int k) const {
    return {parametric[0][k], parametric[1][k], parametric[2][k]};
  }
};

/// Inverts the maps of a block; the same bits as cells::inverse_map one by one.
void invert(mesh::Shape shape, PairBlock& block);

/// Proves points strictly inside or outside of their cells; as cells::filter one by one.
void contain(mesh::Shape shape, PairBlock& block);

} // namespace insitu::query

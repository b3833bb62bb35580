#pragma once

#include <cstdint>

#include "mesh/shape.h"

/// Kernels over blocks of (cell, point) pairs, compiled per SIMD target and dispatched at run time.
namespace insitu::query {

constexpr int block_size = 64;

/// At most block_size pairs of one shape, transposed. Rows are a cache line longer than they need
/// be, so that a cell's numbers do not fall into few sets of the cache.
struct PairBlock {
  static constexpr int row = block_size + 8;
  int count = 0;
  alignas(64) double vertex[8][3][row];
  alignas(64) double point[3][row];
  alignas(64) double parametric[3][row]; ///< by invert
  alignas(64) double margin[row];        ///< by invert; see cells::InverseMap
  alignas(64) double error[row];         ///< by invert; see cells::InverseMap
  std::uint64_t converged;               ///< by invert: bit k is pair k's
  std::uint64_t inside, outside;         ///< by contain: proven; neither: undecided

  /// The pairs' bits.
  std::uint64_t all() const {
    return count == 64 ? ~std::uint64_t(0) : (std::uint64_t(1) << count) - 1;
  }
};

/// Inverts the maps of a block; the same bits as cells::inverse_map one by one.
void invert(mesh::Shape shape, PairBlock& block);

/// Proves points strictly inside or outside of their cells; as cells::filter one by one.
void contain(mesh::Shape shape, PairBlock& block);

} // namespace insitu::query

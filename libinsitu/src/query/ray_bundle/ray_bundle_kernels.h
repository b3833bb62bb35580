#pragma once

#include <cstdint>
#include <vector>

#include "accel/tree/tree.h"
#include "cells/kernels/cell_block.h"
#include "math/vec.h"
#include "mesh/shape.h"

/// What RayBundleLocator does with SIMD; compiled per target and dispatched at run time.
namespace insitu::query {

constexpr int bundle_lanes = 16;  ///< rays of a group
constexpr int bundle_groups = 16; ///< of a bundle
constexpr int bundle_rays = bundle_lanes * bundle_groups;
constexpr int bundle_depth = 32; ///< samples of a ray

/// The samples of a bundle of rays in a frame of their own, in floats: axes u, v across the rays
/// and w along them, the origin in the samples' middle. Sample k of the ray in slot s lies at
/// base[s] + k along[s], up to `rounding` along each axis.
struct BundleSlab {
  math::Vec3d middle, axes[3]; ///< orthonormal
  alignas(64) float base[3][bundle_rays], along[3][bundle_rays];
  float lower[3], upper[3]; ///< of the wanted samples
  double rounding;
  float reach; ///< no coordinate of a wanted sample is larger
  int depth, groups;
  // Of each group, over its wanted samples; nothing of groups without any.
  std::uint32_t wanted[bundle_groups]; ///< bit k: a sample k is wanted
  alignas(64) float group_lower[2][bundle_groups], group_upper[2][bundle_groups];
  /// Samples k with w <= high lie at k <= (high - first_w) last_per_w + index_rounding, and those
  /// with w >= low at k >= (low - last_w) first_per_w - index_rounding.
  alignas(64) float first_w[bundle_groups], last_w[bundle_groups];
  alignas(64) float first_per_w[bundle_groups], last_per_w[bundle_groups];
  alignas(64) float index_rounding[bundle_groups];
  // What cells have been found for a sample: the likelihood, 15 bits, above the cell's number, 16
  // bits; 0: none. That of slot s at [k][s].
  alignas(64) std::int32_t best[bundle_depth][bundle_rays], second[bundle_depth][bundle_rays];
  /// The lowest piece of those cells; -1 with odd cells among them.
  alignas(64) std::int32_t piece[bundle_depth][bundle_rays];
};

/// The places in tree.cells() of cells in whose boxes wanted samples may lie, flat ids from `least`
/// on; false if there are more than `most`. The vector is never made smaller.
bool find_cells(const accel::Tree& tree, const BundleSlab& slab, std::uint32_t least,
                std::size_t most, std::vector<std::uint32_t>& slots, std::size_t& count);

/// Enters cells of one shape, numbered from `first` on, for all samples that they might hold: no
/// sample of a cell is left out, whatever the rounding.
void enter_cells(mesh::Shape shape, const cells::CellBlock& block, int first, BundleSlab& slab);
/// The same, and pieces, -1 for odd cells: then all samples about it.
void enter_cells(mesh::Shape shape, const cells::CellBlock& block, int first,
                 const std::int32_t* pieces, BundleSlab& slab);

/// A field's values at the vertices of up to 64 cells, as CellBlock holds these; of a cell field,
/// in row 0, the cells' own.
struct ValueBlock {
  alignas(64) double vertex[8][cells::CellBlock::row];
};

/// Samples, each with a cell, those of a cell side by side.
struct BundleSamples {
  static constexpr int size = 512, row = size + 8; ///< so few that they stay in the nearest cache
  std::uint16_t cell[row];
  alignas(64) double point[3][row];
  alignas(64) double parametric[3][row];      ///< by invert
  alignas(64) double margin[row], error[row]; ///< by invert; see cells::InverseMap
  alignas(64) double value[row];              ///< by invert, if it is given values
};

/// Inverts the maps of samples [begin, end), whose cells have one shape: number c's vertices are
/// column c % 64 of blocks[c / 64]. The same bits as cells::inverse_map. Reads points
/// of up to 7 samples behind the end, and writes answers of these. values: null, or of the blocks'
/// vertices, to be interpolated; the same bits as cells::weighted_mean.
void invert(mesh::Shape shape, const cells::CellBlock* blocks, const ValueBlock* values, int begin,
            int end, BundleSamples& samples);

} // namespace insitu::query

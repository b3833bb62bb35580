#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "accel/tree/tree.h"
#include "cells/kernels/cell_block.h"
#include "core/parallel.h"
#include "math/vec.h"
#include "mesh/view.h"
#include "query/location.h"

/// What RayBundleLocator does with SIMD; compiled per target and dispatched at run time.
namespace insitu::query {

constexpr int bundle_lanes = 16;  ///< rays of a group
constexpr int bundle_groups = 64; ///< of a bundle
constexpr int bundle_rays = bundle_lanes * bundle_groups, bundle_rays_log2 = 10;
static_assert(bundle_rays == 1 << bundle_rays_log2);
constexpr int bundle_depth = 32; ///< samples of a ray

/// By slot, in columns.
struct BundleRays {
  alignas(64) double origin[3][bundle_rays], direction[3][bundle_rays];
  alignas(64) double inverse[3][bundle_rays]; ///< 1 / direction

  math::Vec3d origin_of(int slot) const {
    return {origin[0][slot], origin[1][slot], origin[2][slot]};
  }
  math::Vec3d direction_of(int slot) const {
    return {direction[0][slot], direction[1][slot], direction[2][slot]};
  }
  void set(int slot, const math::Vec3d& from, const math::Vec3d& along) {
    for (int a = 0; a < 3; ++a) {
      origin[a][slot] = from[a];
      direction[a][slot] = along[a];
      inverse[a][slot] = 1.0 / along[a];
    }
  }
};

/// A sample's cell, or -1, and what was interpolated there.
struct ValueSample {
  std::int64_t cell;
  double value;
};

/// A sample is not asked for, near no cell so far, near one, or proven to be in one.
enum SampleState : std::int32_t { unwanted = -1, untouched, touched, claimed };

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
  /// What is known of sample k of slot s, at [k][s].
  alignas(64) std::int32_t state[bundle_depth][bundle_rays];
  /// The lowest piece of the cells that may hold it; -1 with odd cells among them.
  alignas(64) std::int32_t piece[bundle_depth][bundle_rays];
};

/// The places in tree.cells() of cells and gridlets in whose boxes wanted samples may lie; false if
/// there are more than `most`. The vector is never made smaller.
bool find_cells(const accel::Tree& tree, const BundleSlab& slab, std::size_t most,
                std::vector<std::uint32_t>& slots, std::size_t& count);

/// A field's values at the vertices of up to 64 cells, as CellBlock holds these; of a cell field,
/// in row 0, the cells' own.
struct ValueBlock {
  alignas(64) double vertex[8][cells::CellBlock::row];
};

/// Samples that cells may hold, those of a cell side by side.
struct CellSamples {
  static constexpr int size = 1024, row = size + 3 * bundle_lanes;
  int count = 0;
  /// Of hexahedra, the samples' coordinates, as far as they are known.
  alignas(64) float start[3][row];
  alignas(64) std::int32_t place[row] = {}; ///< k bundle_rays + slot
};
struct BundleLists {
  CellSamples found, likely;
};

/// Where claims go: to places answer[slot] + k.
struct BundleClaims {
  const BundleRays* rays;
  bool one_origin;            ///< all rays begin where that of slot 0 does
  double first, step;         ///< sample k lies at (first + k + 1/2) step
  const std::int32_t* answer; ///< by slot
  const std::int64_t* cells;  ///< flat ids of the block's
  const ValueBlock* values;   ///< of the block's, or null
  bool values_at_vertices;
  ValueSample* samples; ///< or null
  Location* locations;  ///< or null
};

/// Cells that are boxes side by side: a gridlet's, or a structured block's.
struct LatticeCells {
  // Even ones; lengths in cells, but for the first.
  double start[3], steps_a_unit[3]; ///< where cells are counted from; cells
  double begin[3];                  ///< the first one's number
  double least[3];                  ///< places so near to a face may be on its other side
  double most[3];                   ///< the number behind the last one's, less that
  /// Of others: coordinates of faces, ascending, [plane_count]; null: even ones.
  const double* planes[3] = {nullptr, nullptr, nullptr};
  std::int64_t plane_count[3];
  std::int64_t first_cell, next[3];         ///< a flat id; from it to the next along each axis
  mesh::Shape shape;                        ///< voxels or hexahedra
  const std::uint64_t* full = nullptr;      ///< a bit a cell that is there; null: all are
  const mesh::PieceView* blanked = nullptr; ///< the piece, where some cells may not exist
  std::int64_t first_of_piece = 0;          ///< flat id
  double low[3], high[3];                   ///< a box that holds all of it, with some slack
  float lower[3][1], upper[3][1];           ///< along the slab's axes, rounded outwards
};

/// A number a vertex of such cells, that of the first one's lowest at `first` (null: none is
/// known).
struct LatticeNumbers {
  const std::byte* first = nullptr;
  bool is_float32 = false;
  std::int64_t next[3] = {0, 0, 0}; ///< bytes to the next along each axis; a number's size along i
};

/// Where rays of slots [0, rays) are in the slab's frame, of which middle, axes, depth and rounding
/// are known.
void place_rays(const BundleClaims& to, int rays, BundleSlab& slab);
/// Where each group's wanted samples are, and all.
void bound_groups(const std::uint32_t* wanted, BundleSlab& slab);

/// What a stretch begins with. wanted: by slot, bit k: sample k is wanted.
void set_states(const std::uint32_t* wanted, BundleSlab& slab);
/// Leaves those that are not claimed in `wanted`.
void clear_claimed(const BundleSlab& slab, std::uint32_t* wanted);
/// Claims all samples strictly inside of the cells, and touches those on faces or too near to tell;
/// how many are claimed. With numbers it writes to.samples, to the bit as cells::weighted_mean, and
/// to.locations; without, it gives `answer` places and locations, some at a time.
using AnswerPlaces =
    core::FunctionRef<void(std::span<const std::uint16_t> places, std::span<const Location> at)>;
int claim_lattice(const LatticeCells& cells, const LatticeNumbers& numbers, BundleSlab& slab,
                  const BundleClaims& to, AnswerPlaces answer);
/// Touches all samples that the block's cells, of one shape, might hold, whatever the rounding, and
/// claims those that they are proven to hold. pieces: null, or of the cells, -1 for odd ones, which
/// touch all samples about them and claim none.
void claim_cells(mesh::Shape shape, const cells::CellBlock& block, const std::int32_t* pieces,
                 BundleSlab& slab, BundleLists& lists, const BundleClaims& to);
/// The places of a group's samples that are wanted and not claimed; how many. Writes up to
/// bundle_lanes numbers behind them.
int find_unclaimed(int group, const BundleSlab& slab, std::int32_t* places);

} // namespace insitu::query

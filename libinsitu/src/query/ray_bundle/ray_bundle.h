#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "cells/kernels/gather.h"
#include "mesh/box.h"
#include "query/ray_bundle/ray_bundle_kernels.h"
#include "query/sampler.h"

namespace insitu::query {

/// A ray whose samples lie at origin + ((i + 1/2) step) direction, i from 0 on.
struct LatticeRay {
  math::Vec3d origin, direction;
};

/// Numbers to interpolate at samples.
class CellValues {
public:
  virtual ~CellValues() = default;
  /// Of the cells themselves, not of their vertices.
  virtual bool is_per_cell() const = 0;
  /// Fills in columns [0, cells.size()), at most CellBlock::size, for cells by flat id.
  virtual void load(std::span<const std::int64_t> cells, ValueBlock& block) const = 0;
  /// At locations: the cell's number, or cells::weighted_mean of the vertices'; 0 where there is
  /// none.
  virtual void at(std::span<const Location> at, double* values) const = 0;
  /// Where the numbers at a piece's vertices lie, if they lie there as they are.
  struct AtVertices {
    const std::byte* first = nullptr; ///< vertex 0's; null: not said
    mesh::ItemLayout layout;
    bool is_float32 = false;
  };
  virtual AtVertices at_vertices(std::int32_t /*piece*/) const { return {}; }
};

struct RayBundleScratch;
struct ShapeCells;

/// Locates samples along neighbouring rays cell by cell: the tree is asked once for all cells that
/// the samples of a stretch might lie in; each cell's linearised inverse map, in floats, names the
/// samples that it may hold; Newton's certificate proves those that it does, many samples of a cell
/// at once. Gridlets, and uniform and rectilinear blocks, take the samples in all their cells at
/// once: there a sample's place along each axis tells its cell. What no cell is proven to hold, on
/// faces mostly, goes through Sampler::locate_serial, and so does everything where a proof is not
/// enough (PointQuery), where cells may fold, and where the cells are as many as the samples. A
/// sample near no cell is outside.
///
/// The answers are locate_serial's, but for parametric coordinates of hexahedra, which differ by
/// what Newton's method leaves of them (less than 1e-9), and where cells overlap without folding:
/// then in `standard` any cell that is proven to hold the sample. A sample's coordinates hang on
/// its cell and the rays alone, not on what else the mesh has, however it was located.
///
/// Not thread-safe; its scratch is the thread's, so one at a time may be used on a thread.
class RayBundleLocator {
public:
  static constexpr int most_rays = bundle_rays, most_depth = bundle_depth;

  /// The sampler's mesh must stay committed.
  RayBundleLocator(const Sampler& sampler, const LocateOptions& options);

  /// At most most_rays. row: so many of them make a row of pixels, one row after the other, so that
  /// neighbours across are known as well; any value gives the same answers.
  void set_rays(std::span<const LatticeRay> rays, int row, double step);

  /// Samples first to first + depth - 1, depth at most most_depth, of each ray r: those whose bit k
  /// is set in wanted[r] go to locations[r * depth + k]; the others there are left alone.
  void locate(std::int64_t first, int depth, std::span<const std::uint32_t> wanted,
              std::span<Location> locations);
  /// The same with what `from` says at the samples that have a cell, to the bit. A cell's numbers
  /// are loaded once for all of its samples. locations: may be empty.
  void locate(std::int64_t first, int depth, std::span<const std::uint32_t> wanted,
              const CellValues& from, std::span<ValueSample> samples,
              std::span<Location> locations = {});

  /// Of all calls: samples, and those of them that went through Sampler::locate_serial.
  std::int64_t samples() const { return samples_; }
  std::int64_t left() const { return left_; }

private:
  void run(std::int64_t first, int depth, std::span<const std::uint32_t> wanted);
  math::Vec3d point(int place) const;
  void answer(std::span<const std::uint16_t> places, std::span<const Location> at) const;
  int take_wanted(std::span<const std::uint32_t> wanted);
  BundleClaims claims();
  static bool has_places(const mesh::PieceView& piece);
  mesh::Box box_of_samples() const;
  int claim_in_blocks();
  bool set_block(const mesh::PieceView& piece, const mesh::Box& samples, LatticeCells& cells,
                 std::int64_t* lowest, mesh::Box& box);
  static bool set_even_axis(const mesh::PieceView& piece, int axis, LatticeCells& cells);
  bool set_planes(const mesh::PieceView& piece, int axis, const mesh::Box& samples,
                  std::int64_t& lowest, LatticeCells& cells);
  int claim_in_gridlets(std::size_t& found);
  int claim_in_lattice(const mesh::Box& box, LatticeCells& cells, const LatticeNumbers& numbers);
  LatticeNumbers numbers_of(std::int32_t piece, const std::int64_t* vertices,
                            const std::int64_t* lowest) const;
  bool set_slab();
  bool claim_in_all_cells(int samples);
  void claim_in_shape(const cells::CellGather& gather, mesh::Shape shape, const ShapeCells& of);
  void settle_group(int g);
  void leave(int place);
  void locate_rest(bool tried);
  void claim_in_owners();
  std::int64_t cell_at(int place) const;

  const Sampler sampler_;
  const LocateOptions options_;
  RayBundleScratch& s_;
  bool usable_;             ///< a proof is worth something
  bool has_blocks_;         ///< some pieces have places
  bool one_origin_ = false; ///< of the rays
  bool ranked_;             ///< a proof counts only where no odd cell may hold the sample
  double step_ = 0.0;
  std::int64_t first_ = 0;
  int depth_ = 0, rays_ = 0, row_ = 1, groups_ = 0;
  Location* locations_ = nullptr;        ///< or null
  const CellValues* from_ = nullptr;     ///< or null
  ValueSample* value_samples_ = nullptr; ///< or null
  std::int64_t samples_ = 0, left_ = 0;
};

} // namespace insitu::query

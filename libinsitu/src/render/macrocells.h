#pragma once

#include <array>
#include <cstdint>

#include "core/memory.h"
#include "core/parallel.h"
#include "query/sampler.h"
#include "render/camera.h"
#include "render/scalar_field.h"
#include "render/transfer_function.h"

namespace insitu::render {

/// A uniform grid over a box.
struct MacrocellGrid {
  math::Vec3d low, size; ///< the lowest corner; the extent of one macrocell
  std::array<int, 3> counts{0, 0, 0};

  std::int64_t count() const { return std::int64_t(counts[0]) * counts[1] * counts[2]; }
};

/// The least and greatest value that a scalar takes in the cells that meet a macrocell, rounded
/// outwards to float; lower > upper where there is none. Cells with a NaN at a vertex are marked:
/// what is drawn of NaN does not depend on the range.
class Macrocells {
public:
  struct Range {
    float lower, upper;
  };

  /// About `cells_each` owning cells to a macrocell of the mesh's bounds, at most 2^24 of them.
  Macrocells(const query::Sampler& sampler, const ScalarField& field, const core::Threads& threads,
             core::Memory& memory, double cells_each = 64);

  /// New values on the same cells: no memory is allocated, no geometry is made anew.
  void refresh(const query::Sampler& sampler, const ScalarField& field,
               const core::Threads& threads);

  const MacrocellGrid& grid() const { return grid_; }
  const Range& range(std::int64_t i) const { return ranges_[std::size_t(i)]; }
  bool has_nan(std::int64_t i) const { return has_nan_[std::size_t(i)] != 0; }
  std::int64_t bytes() const;

private:
  MacrocellGrid grid_;
  core::Buffer<Range> ranges_;
  core::Buffer<std::uint8_t> has_nan_;
};

/// The greatest opacity that a transfer function gives to the values of each macrocell: an upper
/// bound of what any sample in it gets, for skipping (0: nothing shows) and as a majorant of the
/// extinction. Made anew when the function changes; the cells are not read.
class Majorants {
public:
  Majorants(const Macrocells& cells, const TransferFunction& function, const core::Threads& threads,
            core::Memory& memory);

  const MacrocellGrid& grid() const { return grid_; }
  /// Opacity per unit distance, as the function states it (0 to 1).
  float opacity(std::int64_t i) const { return opacity_[std::size_t(i)]; }
  /// The part of macrocells that nothing shows of.
  double empty_share() const { return empty_share_; }

private:
  MacrocellGrid grid_;
  core::Buffer<float> opacity_;
  double empty_share_ = 0;
};

/// Visits the macrocells that the ray passes for t in [near, far], in order: visit(i, from, to)
/// until it returns false; from and to are clamped to [near, far], and follow each other without a
/// gap. A 3D-DDA (Amanatides, Woo 1987), its crossings computed from the planes, not added up, so
/// that long rays do not drift.
template <class Visit>
void for_each_macrocell(const MacrocellGrid& grid, const Ray& ray, double near, double far,
                        Visit&& visit);

} // namespace insitu::render

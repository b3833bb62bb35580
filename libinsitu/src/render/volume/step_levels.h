#pragma once

#include <cstdint>

#include "core/counted_vector.h"
#include "render/color/transfer_function.h"
#include "render/volume/macrocells.h"

namespace insitu::render {

/// Which spacing of samples each macrocell needs for an error bound. Spacings are a base step times
/// 3^level, so that the middle of a long stretch is the middle of one of its short ones, and
/// samples stay on one lattice.
///
/// The bound: a sample in the middle of a stretch of length h misses the integral of g over it by
/// at most h / 2 times g's variation there. Over a macrocell that is h / 2 times the variation
/// along the ray, which is taken to be twice the range of g over the macrocell's values, for g the
/// extinction and its product with each colour. In cells of size c a field is smooth, so that for h
/// < c the midpoint rule gains another factor of h / c. A ray's error is to stay below `tolerance`,
/// shared out by length: a macrocell of size s has the part s / diagonal of it. So h min(1, h / c)
/// range <= tolerance s / diagonal. Errors of opposite signs cancel, and what lies behind something
/// opaque counts less: errors found are far smaller. Where the function itself steps nothing is
/// smooth: steps are chosen all the same, and unheld() tells where the bound is not proven.
class StepLevels {
public:
  static constexpr int most_refined = 4, most_coarsened = 2; ///< factors of 3 from the nominal step

  StepLevels(const Macrocells& cells, const TransferFunction& function, double nominal_step,
             double unit_distance, double diagonal, double tolerance,
             const core::CountedAllocator<std::uint8_t>& counted = {});

  static constexpr int bytes_each = 1; ///< of a macrocell

  const MacrocellGrid& grid() const { return grid_; }
  double base_step() const { return base_step_; }
  int count() const { return count_; }
  /// Macrocells where the bound is not held: the shortest steps are too long, or the opacity makes
  /// a step within their values that is too large for theirs.
  std::int64_t unheld() const { return unheld_; }
  int level(std::int64_t macrocell) const { return level_[std::size_t(macrocell)]; }
  /// 3^level.
  static std::int64_t stride(int level) {
    constexpr std::int64_t strides[] = {1, 3, 9, 27, 81, 243, 729};
    return strides[level];
  }

private:
  MacrocellGrid grid_;
  double base_step_;
  int count_ = 1;
  std::int64_t unheld_ = 0;
  core::CountedVector<std::uint8_t> level_;
};

} // namespace insitu::render

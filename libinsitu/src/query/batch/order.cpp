#include "query/batch/order.h"

#include <algorithm>
#include <cmath>

#include "math/morton.h"

namespace insitu::query {

namespace {

using accel::morton::Coded;
using math::Vec3d;

constexpr int axis_bits = 7; // a grid of 128^3: a batch has about as many points

class Grid {
public:
  explicit Grid(const accel::Tree& tree) : low_(tree.bounds_min()) {
    const Vec3d size = tree.bounds_max() - low_;
    for (int a = 0; a < 3; ++a)
      per_unit_[a] = size[a] > 0.0 ? double(1 << axis_bits) / size[a] : 0.0;
  }
  std::uint32_t code(const Vec3d& p) const {
    return math::morton_code(place(p, 0), place(p, 1), place(p, 2));
  }

private:
  std::uint32_t place(const Vec3d& p, int a) const {
    constexpr double most = (1 << axis_bits) - 1;
    const double t = (p[a] - low_[a]) * per_unit_[a];
    return std::uint32_t(t > 0.0 ? (t < most ? t : most) : 0.0); // NaN: 0
  }
  Vec3d low_, per_unit_;
};

} // namespace

bool is_incoherent(std::span<const Vec3d> points, const accel::Tree& tree) {
  // Small trees stay in the cache, and small batches have too few neighbours in space.
  constexpr std::int64_t few_cells = 8192;
  constexpr std::size_t few_points = 8192, pairs = 64;
  if (tree.cell_count() < few_cells || points.size() < few_points)
    return false;
  // In units of an average cell, by axis, since meshes may be flat.
  constexpr double far = 8.0;
  const Vec3d size = tree.bounds_max() - tree.bounds_min();
  const double cells_an_axis = std::cbrt(double(tree.cell_count()));
  std::size_t apart = 0;
  for (std::size_t i = 0; i < pairs; ++i) {
    const std::size_t at = i * (points.size() - 2) / pairs;
    const Vec3d d = points[at + 1] - points[at];
    double cells = 0.0;
    for (int a = 0; a < 3; ++a)
      if (size[a] > 0.0)
        cells = std::max(cells, std::fabs(d[a]) / size[a] * cells_an_axis);
    apart += cells > far;
  }
  return apart > pairs / 2;
}

std::span<const Coded> SpatialOrder::sort(const core::Threads& threads,
                                          std::span<const Vec3d> points, const accel::Tree& tree) {
  items_.resize_discard(points.size());
  scratch_.resize_discard(points.size());
  const Grid grid(tree);
  accel::morton::sort_by_code(items_.data(), scratch_.data(), std::int64_t(points.size()),
                              3 * axis_bits, threads,
                              [&](std::int64_t begin, std::int64_t end, Coded* to) {
                                for (std::int64_t i = begin; i < end; ++i)
                                  to[i] = {grid.code(points[std::size_t(i)]), std::uint32_t(i)};
                              });
  return {items_.data(), points.size()};
}

} // namespace insitu::query

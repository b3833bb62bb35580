#include "query/order.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace insitu::query {

namespace {

using math::Vec3d;
using Item = SpatialOrder::Item;

constexpr int axis_bits = 7; // a grid of 128^3: a batch has about as many points
constexpr int digit_bits[2] = {11, 3 * axis_bits - 11};
constexpr std::size_t most_chunks = 16, least_chunk = 4096;

/// The low 7 bits, two apart.
constexpr std::uint32_t spread(std::uint32_t x) {
  x = (x | x << 8) & 0x0000f00f;
  x = (x | x << 4) & 0x000c30c3;
  return (x | x << 2) & 0x00249249;
}

constexpr auto spread_table = [] {
  std::array<std::uint32_t, 1u << axis_bits> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i)
    table[i] = spread(i);
  return table;
}();

class Grid {
public:
  explicit Grid(const accel::Tree& tree) : low_(tree.bounds_min()) {
    const Vec3d size = tree.bounds_max() - low_;
    for (int a = 0; a < 3; ++a)
      per_unit_[a] = size[a] > 0.0 ? double(spread_table.size()) / size[a] : 0.0;
  }
  std::uint32_t code(const Vec3d& p) const {
    return spread_table[place(p, 0)] | spread_table[place(p, 1)] << 1 |
           spread_table[place(p, 2)] << 2;
  }

private:
  std::uint32_t place(const Vec3d& p, int a) const {
    constexpr double most = double(spread_table.size() - 1);
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

std::span<const Item> SpatialOrder::sort(const core::Threads& threads,
                                         std::span<const Vec3d> points, const accel::Tree& tree) {
  const std::size_t n = points.size();
  items_.resize_discard(n);
  sorted_.resize_discard(n);
  const std::size_t chunk = std::max(least_chunk, (n + most_chunks - 1) / most_chunks);
  const Grid grid(tree);
  using Histogram = std::array<std::uint32_t, 1u << digit_bits[0]>;
  std::vector<Histogram> starts((n + chunk - 1) / chunk);
  Item* from = items_.data();
  Item* to = sorted_.data();
  int shift = 0;
  for (int pass = 0; pass < 2; ++pass) { // least significant digit first
    const std::uint32_t mask = (1u << digit_bits[pass]) - 1;
    threads.parallel_for(std::int64_t(n), std::int64_t(chunk),
                         [&](std::int64_t begin, std::int64_t end) {
                           Histogram& counts = starts[std::size_t(begin) / chunk];
                           counts.fill(0);
                           for (auto i = std::size_t(begin); i < std::size_t(end); ++i) {
                             if (pass == 0)
                               from[i] = {std::uint32_t(i), grid.code(points[i])};
                             ++counts[(from[i].code >> shift) & mask];
                           }
                         });
    std::uint32_t sum = 0;
    for (std::size_t digit = 0; digit <= mask; ++digit)
      for (Histogram& counts : starts) {
        const std::uint32_t count = counts[digit];
        counts[digit] = sum;
        sum += count;
      }
    threads.parallel_for(std::int64_t(n), std::int64_t(chunk),
                         [&](std::int64_t begin, std::int64_t end) {
                           Histogram& next = starts[std::size_t(begin) / chunk];
                           for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
                             to[next[(from[i].code >> shift) & mask]++] = from[i];
                         });
    std::swap(from, to);
    shift += digit_bits[pass];
  }
  return {from, n};
}

} // namespace insitu::query

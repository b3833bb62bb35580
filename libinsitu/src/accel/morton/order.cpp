#include "accel/morton/order.h"

#include <algorithm>
#include <bit>

#include "math/morton.h"

namespace insitu::accel::morton {

namespace {

/// Bits an axis, for a grid of about two boxes a cell at least.
int axis_bits(std::int64_t cells) {
  return std::min(math::morton_axis_bits, (int(std::bit_width(std::uint64_t(cells))) + 3) / 3);
}

class Grid {
public:
  Grid(const Centres& centres, int bits) {
    double most = 0.0; // cells along an axis
    for (int a = 0; a < 3; ++a)
      most = std::max(most, cells_along(centres, a));
    for (int a = 0; a < 3; ++a) {
      const double range = double(centres.upper[a]) - double(centres.lower[a]);
      const double steps = (double(1 << bits) - 0.5) * (cells_along(centres, a) / most);
      lower_[a] = centres.lower[a];
      scale_[a] = range > 0.0 ? steps / range : 0.0;
    }
  }
  std::uint32_t code(const Box& b) const {
    const auto axis = [&](int a) {
      const double at = (double(b.lower[a] + b.upper[a]) - lower_[a]) * scale_[a];
      return std::uint32_t(std::int32_t(at)) % (1u << math::morton_axis_bits);
    };
    return math::morton_code(axis(0), axis(1), axis(2));
  }

private:
  /// In proportion; more than zero wherever centres differ.
  static double cells_along(const Centres& centres, int a) {
    const double range = double(centres.upper[a]) - double(centres.lower[a]);
    return range > 0.0 ? std::clamp(range / centres.extent[a], 1e-30, 1e30) : 0.0;
  }
  double lower_[3], scale_[3];
};

} // namespace

Centres::Centres(const Box* boxes, std::uint32_t n) {
  float sum[3] = {0.0f, 0.0f, 0.0f};
  for (std::uint32_t i = 0; i < n; ++i)
    for (int a = 0; a < 3; ++a) {
      const float l = boxes[i].lower[a], u = boxes[i].upper[a], twice = l + u;
      lower[a] = twice < lower[a] ? twice : lower[a];
      upper[a] = twice > upper[a] ? twice : upper[a];
      sum[a] += u - l;
    }
  for (int a = 0; a < 3; ++a)
    extent[a] = double(sum[a]);
}

void Centres::add(const Centres& c) {
  for (int a = 0; a < 3; ++a) {
    lower[a] = std::min(lower[a], c.lower[a]);
    upper[a] = std::max(upper[a], c.upper[a]);
    extent[a] += c.extent[a];
  }
}

void order(Coded* cells, Coded* scratch, std::int64_t n, const Box* boxes, const Centres& centres,
           const core::Threads& threads) {
  const int bits = axis_bits(n);
  const Grid grid(centres, bits);
  if (constexpr std::int64_t few = 512; n <= few) {
    for (std::int64_t i = 0; i < n; ++i)
      cells[i].code = grid.code(boxes[cells[i].id]);
    std::sort(cells, cells + n, [](const Coded& a, const Coded& b) {
      return a.code != b.code ? a.code < b.code : a.id < b.id;
    });
    return;
  }
  sort_by_code(cells, scratch, n, 3 * bits, threads,
               [&](std::int64_t begin, std::int64_t end, Coded* to) {
                 for (std::int64_t i = begin; i < end; ++i)
                   to[i] = {grid.code(boxes[cells[i].id]), cells[i].id};
               });
}

} // namespace insitu::accel::morton

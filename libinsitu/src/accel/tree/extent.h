#pragma once

#include "accel/tree/node.h"
#include "math/number.h"

namespace insitu::accel {

using math::largest_coordinate;

/// The box of gathered vertices.
class Extent {
public:
  INSITU_HD explicit Extent(const math::Vec3d& p) : lo_(p), hi_(p), sum_(p) {}
  INSITU_HD void add(const math::Vec3d& p) {
    for (int a = 0; a < 3; ++a) {
      lo_[a] = p[a] < lo_[a] ? p[a] : lo_[a];
      hi_[a] = p[a] > hi_[a] ? p[a] : hi_[a];
    }
    sum_ += p; // keeps a NaN, which the comparisons may lose
  }
  INSITU_HD Box box(const math::Vec3d& origin) const {
    Box b;
    for (int a = 0; a < 3; ++a) {
      const double l = lo_[a] - origin[a], u = hi_[a] - origin[a];
      if (!(l > -largest_coordinate && u < largest_coordinate && sum_[a] - sum_[a] == 0.0))
        return Box{};
      b.lower[a] = round_down(l);
      b.upper[a] = round_up(u);
    }
    return b;
  }

private:
  math::Vec3d lo_, hi_, sum_;
};

INSITU_HD inline bool is_empty(const Box& b) {
  return !(b.lower[0] <= b.upper[0]);
}

} // namespace insitu::accel

#pragma once

#include <cstdint>

#include "accel/morton/sort.h"
#include "accel/tree/node.h"

namespace insitu::accel::morton {

/// Where the centres of a set of cells lie, times two, and the sum of the cells' extents.
struct Centres {
  float lower[3] = {3e38f, 3e38f, 3e38f};
  float upper[3] = {-3e38f, -3e38f, -3e38f};
  double extent[3] = {0.0, 0.0, 0.0};

  Centres() = default;
  Centres(const Box* boxes, std::uint32_t n);
  void add(const Centres& c);
  bool are_one_point() const {
    return lower[0] == upper[0] && lower[1] == upper[1] && lower[2] == upper[2];
  }
};

/// Gives each of n cells (ids are flat ones) its code on a grid over their centres, whose steps are
/// in proportion to the cells' extents and fine enough for most cells to have one of their own, and
/// sorts them by it. Cells that come in ascending order stay so where codes are equal. boxes: by
/// flat id. scratch: as many items, overwritten. The result does not depend on the thread count.
void order(Coded* cells, Coded* scratch, std::int64_t n, const Box* boxes, const Centres& centres,
           const core::Threads& threads);

} // namespace insitu::accel::morton

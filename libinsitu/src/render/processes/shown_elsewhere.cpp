#include "render/processes/shown_elsewhere.h"

#include <algorithm>
#include <cmath>

#include "accel/tree/tree.h"

namespace insitu::render {

using math::Vec3d;

ShownElsewhere::ShownElsewhere(const mesh::Box& whole, int processes)
    : whole_(whole), size_(whole.size() / double(side)), parts_a_word_(processes < 65536 ? 4 : 2),
      shown_(std::size_t(side) * side * side / std::size_t(parts_a_word_)), mine_(shown_.size()) {
  static_assert(side % 4 == 0);
}

std::size_t ShownElsewhere::word_of(int i, int j, int k) const {
  return std::size_t(((k * side + j) * side + i) / parts_a_word_);
}
int ShownElsewhere::shift_of(int i) const {
  return 64 / parts_a_word_ * (i % parts_a_word_);
}

ShownElsewhere::Range ShownElsewhere::parts_of(const Vec3d& low, const Vec3d& high) const {
  Range range;
  const auto part = [&](int a, double x) {
    const double at = (x - whole_.low[a]) / size_[a]; // no number where the mesh is flat
    return at > 0 ? (at < side ? int(at) : side - 1) : 0;
  };
  for (std::size_t a = 0; a < 3; ++a) {
    // A hundredth of a part more, against rounding.
    const double slack = 0.01 * size_[int(a)];
    range.first[a] = size_[int(a)] > 0 ? part(int(a), low[int(a)] - slack) : 0;
    range.last[a] = size_[int(a)] > 0 ? part(int(a), high[int(a)] + slack) : 0;
  }
  return range;
}

void ShownElsewhere::note(const accel::Tree& tree, const Majorants* majorants, double step) {
  std::fill(mine_.begin(), mine_.end(), 0);
  const Vec3d about{step, step, step};
  const auto mark = [&](const Vec3d& low, const Vec3d& high) {
    const Range range = parts_of(low - about, high + about);
    for (int k = range.first[2]; k <= range.last[2]; ++k)
      for (int j = range.first[1]; j <= range.last[1]; ++j)
        for (int i = range.first[0]; i <= range.last[0]; ++i)
          mine_[word_of(i, j, k)] |= std::int64_t(1) << shift_of(i);
  };
  if (tree.empty())
    return;
  if (!majorants)
    return mark(tree.bounds_min(), tree.bounds_max());
  const MacrocellGrid& grid = majorants->grid();
  for (int k = 0; k < grid.counts[2]; ++k)
    for (int j = 0; j < grid.counts[1]; ++j)
      for (int i = 0; i < grid.counts[0]; ++i)
        if (majorants->opacity(grid.index(i, j, k)) > 0)
          mark({grid.plane(0, i), grid.plane(1, j), grid.plane(2, k)},
               {grid.plane(0, i + 1), grid.plane(1, j + 1), grid.plane(2, k + 1)});
}

void ShownElsewhere::exchange(parallel::World& world) {
  shown_ = mine_;
  world.reduce(shown_, parallel::Reduction::sum);
  for (std::size_t w = 0; w < shown_.size(); ++w)
    shown_[w] = std::int64_t(std::uint64_t(shown_[w]) - std::uint64_t(mine_[w])); // no part borrows
}

bool ShownElsewhere::is_shown(const Vec3d& low, const Vec3d& high) const {
  const Range range = parts_of(low, high);
  const std::uint64_t one_part = (std::uint64_t(1) << 64 / parts_a_word_) - 1;
  for (int k = range.first[2]; k <= range.last[2]; ++k)
    for (int j = range.first[1]; j <= range.last[1]; ++j)
      for (int i = range.first[0]; i <= range.last[0]; ++i)
        if (std::uint64_t(shown_[word_of(i, j, k)]) >> shift_of(i) & one_part)
          return true;
  return false;
}

std::unique_ptr<Majorants> ShownElsewhere::with(const Majorants& majorants,
                                                core::Memory& memory) const {
  const MacrocellGrid& grid = majorants.grid();
  return std::make_unique<Majorants>(majorants, memory, [&](int i, int j, int k) {
    return is_shown({grid.plane(0, i), grid.plane(1, j), grid.plane(2, k)},
                    {grid.plane(0, i + 1), grid.plane(1, j + 1), grid.plane(2, k + 1)});
  });
}

} // namespace insitu::render

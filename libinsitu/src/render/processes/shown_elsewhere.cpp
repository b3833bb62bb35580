#include "render/processes/shown_elsewhere.h"

#include <algorithm>
#include <cmath>

#include "accel/tree/tree.h"

namespace insitu::render {

using math::Vec3d;

namespace {

constexpr int bits_a_part = 16, parts_a_word = 4; // of up to 65535 processes

std::size_t word_of(int i, int j, int k) {
  return std::size_t((k * ShownElsewhere::side + j) * ShownElsewhere::side + i) / parts_a_word;
}
int shift_of(int i) {
  return bits_a_part * (i % parts_a_word);
}
static_assert(ShownElsewhere::side % parts_a_word == 0);

} // namespace

ShownElsewhere::ShownElsewhere(const mesh::Box& whole)
    : whole_(whole), size_(whole.size() / double(side)),
      shown_(std::size_t(side) * side * side / parts_a_word), mine_(shown_.size()) {}

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
    shown_[w] -= mine_[w]; // no part borrows: it counts this process
}

bool ShownElsewhere::is_shown(const Vec3d& low, const Vec3d& high) const {
  const Range range = parts_of(low, high);
  for (int k = range.first[2]; k <= range.last[2]; ++k)
    for (int j = range.first[1]; j <= range.last[1]; ++j)
      for (int i = range.first[0]; i <= range.last[0]; ++i)
        if (std::uint64_t(shown_[word_of(i, j, k)]) >> shift_of(i) & 0xffff)
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

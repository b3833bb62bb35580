#include <algorithm>
#include <cmath>

#include "workload/amr.h"
#include "workload/mesh.h"

namespace insitu::workload {

namespace {

constexpr double box = 256.0;
constexpr double radius = 85.0;
constexpr int most_levels = 4;
constexpr double buffer = 2.0; ///< cells of a level between the front and a coarser one

double distance_to_front(const math::Vec3d& p) {
  const math::Vec3d d = p - math::Vec3d{box / 2, box / 2, box / 2};
  return std::fabs(std::sqrt(dot(d, d)) - radius);
}

/// Counts leaves, and keeps them if `into` is given.
std::int64_t split(Octree* into, double root_width, int level_count, int level,
                   const std::int32_t* at) {
  const double width = root_width / double(1 << level);
  const math::Vec3d centre{(at[0] + 0.5) * width, (at[1] + 0.5) * width, (at[2] + 0.5) * width};
  // Half a diagonal: the front passes through it at most so far from its centre.
  if (level + 1 == level_count ||
      distance_to_front(centre) > (0.5 * std::sqrt(3.0) + buffer) * width) {
    if (into) {
      into->leaves.levels.push_back(level);
      into->leaves.corners.insert(into->leaves.corners.end(), at, at + 3);
      into->leaves.values.push_back(field(centre) / box);
    }
    return 1;
  }
  std::int64_t count = 0;
  for (int child = 0; child < 8; ++child) {
    const std::int32_t corner[3] = {2 * at[0] + (child & 1), 2 * at[1] + (child >> 1 & 1),
                                    2 * at[2] + (child >> 2)};
    count += split(into, root_width, level_count, level + 1, corner);
  }
  return count;
}

std::int64_t split_all(Octree* into, std::int32_t roots, int level_count) {
  std::int64_t count = 0;
  for (std::int32_t k = 0; k < roots; ++k)
    for (std::int32_t j = 0; j < roots; ++j)
      for (std::int32_t i = 0; i < roots; ++i) {
        const std::int32_t at[3] = {i, j, k};
        count += split(into, box / roots, level_count, 0, at);
      }
  return count;
}

} // namespace

Octree make_front_octree(int roots, int level_count) {
  Octree out;
  out.level_count = level_count;
  out.spacing = box / roots;
  split_all(&out, roots, level_count);
  return out;
}

Octree make_front_octree(std::int64_t cells) {
  int roots = 4;
  std::int64_t before = split_all(nullptr, roots, most_levels);
  for (;;) {
    const std::int64_t next = split_all(nullptr, roots + 1, most_levels);
    if (std::llabs(next - cells) >= std::llabs(before - cells))
      return make_front_octree(roots, most_levels);
    before = next;
    ++roots;
  }
}

} // namespace insitu::workload

#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "accel/camera_rays/frustum.h"
#include "math/vec.h"

namespace insitu::render {

/// Pixels [x0, x1) x [y0, y1) of an image, which a process owns. Its rays are numbered part by part
/// of part_side x part_side pixels, row by row within a part, as they are drawn together.
struct FrameTile {
  static constexpr int side = 64, marched_side = 32, most_rays = side * side;

  int x0, y0, x1, y1, owner;
  int part_side = marched_side;

  std::size_t rays() const { return std::size_t(x1 - x0) * std::size_t(y1 - y0); }
  struct Part {
    int x0, y0, x1, y1;
    std::size_t first_ray;
    std::size_t rays() const { return std::size_t(x1 - x0) * std::size_t(y1 - y0); }
  };
  std::vector<Part> parts() const {
    std::vector<Part> all;
    std::size_t first = 0;
    for (int y = y0; y < y1; y += part_side)
      for (int x = x0; x < x1; x += part_side) {
        all.push_back({x, y, std::min(x + part_side, x1), std::min(y + part_side, y1), first});
        first += all.back().rays();
      }
    return all;
  }
  /// visit(ray, x, y) for all rays of the tile.
  template <class Visit>
  void for_each_ray(Visit&& visit) const {
    for (const Part& part : parts()) {
      std::size_t ray = part.first_ray;
      for (int y = part.y0; y < part.y1; ++y)
        for (int x = part.x0; x < part.x1; ++x)
          visit(ray++, x, y);
    }
  }
};

/// The tiles of an image in groups that are drawn one after the other. A group's tiles lie far from
/// each other, so that all processes have some of what is there, and go round the processes.
inline std::vector<std::vector<FrameTile>> tile_groups(int width, int height, int processes,
                                                       std::int64_t tiles_a_group,
                                                       int part_side = FrameTile::marched_side) {
  constexpr int side = FrameTile::side;
  const std::int64_t columns = (width + side - 1) / side, rows = (height + side - 1) / side;
  const std::int64_t tiles = columns * rows, groups = (tiles + tiles_a_group - 1) / tiles_a_group;
  std::vector<std::vector<FrameTile>> all(static_cast<std::size_t>(groups));
  std::int64_t dealt = 0;
  for (std::int64_t g = 0; g < groups; ++g)
    for (std::int64_t tile = g; tile < tiles; tile += groups) {
      const int x0 = int(tile % columns) * side, y0 = int(tile / columns) * side;
      all[std::size_t(g)].push_back({x0, y0, std::min(x0 + side, width),
                                     std::min(y0 + side, height), int(dealt++ % processes),
                                     part_side});
    }
  return all;
}

/// Whether a box may reach into a frustum.
inline bool may_meet(const accel::Frustum& frustum, const math::Vec3d& low,
                     const math::Vec3d& high) {
  for (const accel::Frustum::Side& side : frustum.sides) {
    double most = side.shift, size = std::fabs(side.shift);
    for (int a = 0; a < 3; ++a) {
      const double from = side.normal[a] * (low[a] - frustum.eye[a]);
      const double to = side.normal[a] * (high[a] - frustum.eye[a]);
      most += std::max(from, to);
      size += std::max(std::fabs(from), std::fabs(to));
    }
    if (!(most >= -1e-12 * size))
      return false;
  }
  return true;
}

} // namespace insitu::render

#include "workload/amr.h"

#include <algorithm>
#include <cmath>

#include "core/random.h"
#include "workload/mesh.h"

namespace insitu::workload {

namespace {

constexpr double box = 256.0;

/// Which blocks of a level there are; n along each axis.
struct Level {
  explicit Level(int blocks) : n(blocks), there(std::size_t(n) * n * n, 0) {}
  std::uint8_t& at(int i, int j, int k) {
    return there[std::size_t(i) + std::size_t(n) * (std::size_t(j) + std::size_t(n) * k)];
  }
  /// How far a block's centre is from the sphere.
  double distance(int i, int j, int k) const {
    const double h = box / n;
    const math::Vec3d c{(i + 0.5) * h - box / 2, (j + 0.5) * h - box / 2, (k + 0.5) * h - box / 2};
    return std::fabs(std::sqrt(dot(c, c)) - 90.0);
  }
  template <class F>
  void for_each(F&& f) {
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i)
          f(i, j, k);
  }
  int n;
  std::vector<std::uint8_t> there;
};

} // namespace

math::Vec3d AmrMesh::centre(const Block& b, std::int64_t cell) const {
  const double h = width(b.level);
  return {(double(b.lower[0] + cell % side) + 0.5) * h,
          (double(b.lower[1] + cell / side % side) + 0.5) * h,
          (double(b.lower[2] + cell / side / side) + 0.5) * h};
}

AmrMesh make_amr(std::int64_t cells) {
  AmrMesh mesh;
  mesh.side = std::max(2, 2 * int(std::lround(8.0 * std::cbrt(double(cells) / 4'018'176.0))));
  mesh.spacing = box / (4.0 * mesh.side);
  Level coarse(4), middle(8), fine(16);
  coarse.for_each([&](int i, int j, int k) { coarse.at(i, j, k) = 1; });
  fine.for_each([&](int i, int j, int k) {
    if (fine.distance(i, j, k) < 15.0)
      fine.at(i, j, k) = middle.at(i / 2, j / 2, k / 2) = 1;
  });
  middle.for_each([&](int i, int j, int k) {
    if (middle.distance(i, j, k) < 40.0)
      middle.at(i, j, k) = 1;
  });
  Level* const levels[] = {&coarse, &middle, &fine};
  for (int l = 0; l < 3; ++l)
    levels[l]->for_each([&](int i, int j, int k) {
      if (levels[l]->at(i, j, k))
        mesh.blocks.push_back({l,
                               {std::int64_t(i) * mesh.side, std::int64_t(j) * mesh.side,
                                std::int64_t(k) * mesh.side}});
    });
  mesh.values.reserve(std::size_t(mesh.cell_count()));
  for (const AmrMesh::Block& b : mesh.blocks)
    for (std::int64_t c = 0; c < mesh.cells_a_block(); ++c)
      mesh.values.push_back(field(mesh.centre(b, c)) / box);
  return mesh;
}

AmrLeaves leaves_of(const AmrMesh& mesh) {
  AmrLeaves out;
  const int half = mesh.side / 2;
  // Blocks of the next level cover octants of a block.
  std::vector<std::int64_t> finer;
  const auto key = [](int level, std::int64_t i, std::int64_t j, std::int64_t k) {
    return ((std::int64_t(level) << 20 | i) << 20 | j) << 20 | k;
  };
  for (const AmrMesh::Block& b : mesh.blocks)
    finer.push_back(
        key(b.level, b.lower[0] / mesh.side, b.lower[1] / mesh.side, b.lower[2] / mesh.side));
  std::sort(finer.begin(), finer.end());
  for (std::size_t n = 0; n < mesh.blocks.size(); ++n) {
    const AmrMesh::Block& b = mesh.blocks[n];
    for (std::int64_t c = 0; c < mesh.cells_a_block(); ++c) {
      const std::int64_t ijk[3] = {c % mesh.side, c / mesh.side % mesh.side,
                                   c / mesh.side / mesh.side};
      std::int64_t child[3];
      for (int a = 0; a < 3; ++a)
        child[a] = 2 * (b.lower[a] / mesh.side) + ijk[a] / half;
      if (std::binary_search(finer.begin(), finer.end(),
                             key(b.level + 1, child[0], child[1], child[2])))
        continue;
      out.levels.push_back(b.level);
      for (int a = 0; a < 3; ++a)
        out.corners.push_back(std::int32_t(b.lower[a] + ijk[a]));
      out.values.push_back(mesh.values[n * std::size_t(mesh.cells_a_block()) + std::size_t(c)]);
    }
  }
  return out;
}

namespace {

/// Calls f(corner) for the cells of level 0, and for the children of a cell.
template <class F>
void for_roots(F&& f) {
  for (std::int32_t root = 0; root < 64; ++root) {
    const std::int32_t corner[3] = {root % 4, root / 4 % 4, root / 16};
    f(corner);
  }
}
template <class F>
void for_children(const std::int32_t* at, F&& f) {
  for (int child = 0; child < 8; ++child) {
    const std::int32_t corner[3] = {2 * at[0] + (child & 1), 2 * at[1] + (child >> 1 & 1),
                                    2 * at[2] + (child >> 2)};
    f(corner);
  }
}

void add_leaf(Octree& octree, int level, const std::int32_t* at) {
  const double width = box / 4 / double(1 << level);
  octree.leaves.levels.push_back(level);
  octree.leaves.corners.insert(octree.leaves.corners.end(), at, at + 3);
  octree.leaves.values.push_back(
      field({(at[0] + 0.5) * width, (at[1] + 0.5) * width, (at[2] + 0.5) * width}) / box);
}

/// Splits a cell of an octree and so on; counts leaves, and keeps them if `into` is given.
std::int64_t split(Octree* into, double reach, int level_count, int level, const std::int32_t* at) {
  const double width = box / 4 / double(1 << level);
  const math::Vec3d centre{(at[0] + 0.5) * width, (at[1] + 0.5) * width, (at[2] + 0.5) * width};
  const math::Vec3d d = centre - math::Vec3d{box / 2, box / 2, box / 2};
  const double wave = std::sin(0.06 * d.x) * std::sin(0.05 * d.y + 1.0) * std::sin(0.07 * d.z);
  const double distance = std::fabs(std::sqrt(dot(d, d)) - 85.0 - 25.0 * wave);
  const std::uint64_t key =
      ((std::uint64_t(level) << 20 | std::uint64_t(at[0])) << 20 | std::uint64_t(at[1])) << 20 |
      std::uint64_t(at[2]);
  if (level + 1 == level_count || distance > reach * width * (0.5 + core::random_unit(9, key, 0))) {
    if (into)
      add_leaf(*into, level, at);
    return 1;
  }
  std::int64_t count = 0;
  for_children(at, [&](const std::int32_t* child) {
    count += split(into, reach, level_count, level + 1, child);
  });
  return count;
}

std::int64_t split_all(Octree* into, double reach, int level_count) {
  std::int64_t count = 0;
  for_roots([&](const std::int32_t* root) { count += split(into, reach, level_count, 0, root); });
  return count;
}

using Cells = std::vector<std::uint64_t>; ///< of one level, sorted: x fastest

std::uint64_t cell_key(const std::int32_t* at) {
  return (std::uint64_t(at[2]) << 20 | std::uint64_t(at[1])) << 20 | std::uint64_t(at[0]);
}

void normalize(Cells& cells) {
  std::sort(cells.begin(), cells.end());
  cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
}

void add_parent(Cells& above, const std::int32_t* at) {
  const std::int32_t parent[3] = {at[0] >> 1, at[1] >> 1, at[2] >> 1};
  const std::uint64_t key = cell_key(parent);
  if (above.empty() || above.back() != key)
    above.push_back(key);
}

void add_leaves(Octree& octree, const std::vector<Cells>& splits, int level,
                const std::int32_t* at) {
  const Cells& own = splits[std::size_t(level)];
  if (!std::binary_search(own.begin(), own.end(), cell_key(at)))
    return add_leaf(octree, level, at);
  for_children(at,
               [&](const std::int32_t* child) { add_leaves(octree, splits, level + 1, child); });
}

} // namespace

Octree make_octree(double reach, int level_count) {
  Octree out;
  out.level_count = level_count;
  out.reach = reach;
  split_all(&out, reach, level_count);
  return out;
}

Octree make_octree(std::int64_t cells) {
  int levels = 2;
  while (levels < 16 && split_all(nullptr, 1.0, levels) < cells)
    ++levels;
  double low = 0.0, high = 1.0;
  for (int i = 0; i < 12; ++i) {
    const double middle = 0.5 * (low + high);
    (split_all(nullptr, middle, levels) < cells ? low : high) = middle;
  }
  return make_octree(high, levels);
}

Octree balanced(const Octree& octree) {
  std::vector<Cells> splits(std::size_t(octree.level_count));
  const AmrLeaves& leaves = octree.leaves;
  for (std::size_t i = 0; i < leaves.levels.size(); ++i)
    if (leaves.levels[i] > 0)
      add_parent(splits[std::size_t(leaves.levels[i] - 1)], &leaves.corners[3 * i]);
  // The neighbours of a cell that is split are of its level at least.
  for (int level = octree.level_count - 1; level > 0; --level) {
    Cells& own = splits[std::size_t(level)];
    normalize(own);
    const std::int32_t cells = 4 << level;
    for (const std::uint64_t key : own)
      for (int n = 0; n < 27; ++n) {
        const std::int32_t at[3] = {std::int32_t(key & 0xfffff) + n % 3 - 1,
                                    std::int32_t(key >> 20 & 0xfffff) + n / 3 % 3 - 1,
                                    std::int32_t(key >> 40) + n / 9 - 1};
        if (std::all_of(at, at + 3, [&](std::int32_t i) { return i >= 0 && i < cells; }))
          add_parent(splits[std::size_t(level - 1)], at);
      }
  }
  normalize(splits[0]);
  Octree out;
  out.level_count = octree.level_count;
  out.reach = octree.reach;
  for_roots([&](const std::int32_t* root) { add_leaves(out, splits, 0, root); });
  return out;
}

std::vector<math::Vec3d> random_amr_points(std::int64_t count) {
  std::vector<math::Vec3d> points(static_cast<std::size_t>(count));
  for (std::size_t i = 0; i < points.size(); ++i)
    for (unsigned a = 0; a < 3; ++a)
      points[i][int(a)] = box * core::random_unit(7, i, a);
  return points;
}

std::vector<math::Vec3d> raster_amr_points(int n) {
  std::vector<math::Vec3d> points;
  points.reserve(std::size_t(n) * std::size_t(n) * std::size_t(n));
  const double h = box / n;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i)
        points.push_back({(i + 0.5) * h, (j + 0.5) * h, (k + 0.5) * h});
  return points;
}

} // namespace insitu::workload

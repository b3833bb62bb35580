#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/box.h"
#include "query/sampler.h"
#include "render/camera/camera.h"
#include "render/color/transfer_function.h"
#include "render/structures/scalar_field.h"

namespace insitu::render {

/// How fine a grid of macrocells is: about so many owning cells to each, and at most so many
/// macrocells.
struct MacrocellFineness {
  static constexpr double usual_cells = 64, largest_count = 0x1p24;

  MacrocellFineness(double cells = usual_cells, double most = largest_count)
      : cells_each(cells), most_macrocells(most) {}

  double cells_each, most_macrocells;
};

/// A uniform grid over a box. The macrocells at its border reach outwards without end, so that
/// every point is in one.
struct MacrocellGrid {
  math::Vec3d low;  ///< the lowest corner
  math::Vec3d size; ///< the extent of one macrocell; 0 along an axis in which the mesh has none
  std::array<int, 3> counts{0, 0, 0};

  std::int64_t count() const { return std::int64_t(counts[0]) * counts[1] * counts[2]; }
  /// The lower plane of layer i.
  double plane(int axis, int i) const { return low[axis] + double(i) * size[axis]; }
  /// The layer that holds a coordinate.
  int layer(int axis, double x) const {
    if (counts[axis] == 1)
      return 0;
    const double at = (x - low[axis]) / size[axis];
    return at > 0 ? (at < counts[axis] ? int(at) : counts[axis] - 1) : 0;
  }
  std::int64_t index(int i, int j, int k) const {
    return i + counts[0] * (j + std::int64_t(counts[1]) * k);
  }
  std::int64_t index(const math::Vec3d& p) const {
    return index(layer(0, p.x), layer(1, p.y), layer(2, p.z));
  }
  /// Whether points along the ray, up to `far`, are rounded by so little, against the margin that
  /// cells are given in Macrocells, that those in a cell are in a macrocell that counts it.
  bool resolves(const Ray& ray, double far) const;

  /// Over a mesh's bounds, which are so many mean cells wide, at least 1 along each axis:
  /// macrocells have a mean cell's proportions, and none is smaller than a quarter of it. cells: of
  /// the mesh. Throws core::Error (INSITU_ERROR_ARGUMENT) for macrocells of no cells.
  static MacrocellGrid over(const mesh::Box& bounds, const double (&across)[3], double cells,
                            const MacrocellFineness& fineness);
  /// Takes fewer macrocells until a cell meets 256 of them at most, on average: boxes of long
  /// oblique cells would fill much of a fine grid. coverage(grid): how many a cell meets.
  void coarsen(core::FunctionRef<double(const MacrocellGrid&)> coverage);

  friend bool operator==(const MacrocellGrid&, const MacrocellGrid&) = default;
};

/// The least and greatest value that a scalar takes in the cells that meet a macrocell; lower >
/// upper where there is none. Cells with a NaN at a vertex, or an infinite value, are marked: what
/// is drawn of NaN does not depend on the range. Ranges are double as fields are: a field of 1e-300
/// or 1e300 has no range in float.
///
/// Cells are given `margin` macrocells more on all sides, and ranges a millionth of the cell's own
/// range and 16 roundings of the value, so that roundings of rays and of interpolation stay within.
class Macrocells {
public:
  static constexpr double margin = 1.0 / 256;
  struct Range {
    double lower, upper;
  };
  /// Of memory, for each of them; and after measure().
  static constexpr std::int64_t bytes_each = sizeof(Range) + 1;
  static constexpr std::int64_t bytes_each_with_size = bytes_each + sizeof(float);

  /// The grid that they make of a mesh; looks at some of its cells.
  static MacrocellGrid grid_of(const query::Sampler& sampler, const MacrocellFineness& fineness);

  /// They fill the mesh's bounds, have the proportions of a mean cell's box; none is smaller than a
  /// quarter of it.
  Macrocells(const query::Sampler& sampler, const ScalarField& field, const core::Threads& threads,
             core::Memory& memory, const MacrocellFineness& fineness = {});
  /// They are those of a grid that is given.
  Macrocells(const query::Sampler& sampler, const ScalarField& field, const MacrocellGrid& grid,
             const core::Threads& threads, core::Memory& memory);
  /// They have what extremes() told of a mesh's parts, the least number of all parts each.
  Macrocells(const MacrocellGrid& grid, std::span<const std::int64_t> extremes,
             core::Memory& memory);

  /// What they hold as integers, so that of macrocells of a mesh's parts on one grid the least ones
  /// are those of the whole mesh.
  std::vector<std::int64_t> extremes() const;
  /// Of parts without cells; with_sizes: as after measure().
  static std::vector<std::int64_t> no_extremes(const MacrocellGrid& grid, bool with_sizes);

  /// New values on the same cells: no memory is allocated, the grid stays.
  void refresh(const query::Sampler& sampler, const ScalarField& field,
               const core::Threads& threads);

  /// Finds the smallest cells; as long as the geometry holds.
  void measure(const query::Sampler& sampler, const core::Threads& threads);
  bool has_sizes() const { return !smallest_.empty(); }

  const MacrocellGrid& grid() const { return grid_; }
  const Range& range(std::int64_t i) const { return ranges_[std::size_t(i)]; }
  bool has_nan(std::int64_t i) const { return has_nan_[std::size_t(i)] != 0; }
  /// The shortest side of the boxes of its cells, sides of no length left out; infinite if there is
  /// none. After measure().
  float smallest_cell(std::int64_t i) const { return smallest_[std::size_t(i)]; }
  std::int64_t bytes() const {
    return std::int64_t(ranges_.bytes() + has_nan_.bytes() + smallest_.bytes());
  }

private:
  MacrocellGrid grid_;
  core::Buffer<Range> ranges_;
  core::Buffer<std::uint8_t> has_nan_;
  core::Buffer<float> smallest_;
};

/// The greatest opacity that a transfer function gives to the values of each macrocell: an upper
/// bound of what any sample in it gets, for skipping (0: nothing shows) and as a majorant of the
/// extinction. Made anew when the function changes; the cells are not read.
class Majorants {
public:
  static constexpr std::int64_t bytes_each = sizeof(float); ///< for a macrocell

  Majorants(const Macrocells& cells, const TransferFunction& function, const core::Threads& threads,
            core::Memory& memory);

  /// The same, but above 0 in macrocells (i, j, k) that are shown, whatever their values.
  Majorants(const Majorants& from, core::Memory& memory,
            core::FunctionRef<bool(int i, int j, int k)> is_shown);

  /// Other values in the same macrocells, or another function: no memory is allocated.
  void refresh(const Macrocells& cells, const TransferFunction& function,
               const core::Threads& threads);

  const MacrocellGrid& grid() const { return grid_; }
  /// Opacity per unit distance, as the function states it (0 to 1), rounded up to float; 0 where it
  /// is below TransferFunction::invisible.
  float opacity(std::int64_t i) const { return opacity_[std::size_t(i)]; }
  /// The part of macrocells that nothing shows of.
  double empty_share() const { return empty_share_; }
  std::int64_t bytes() const { return std::int64_t(opacity_.bytes()); }

private:
  MacrocellGrid grid_;
  core::Buffer<float> opacity_;
  double empty_share_ = 0;
};

/// Visits the macrocells that the ray passes for t in [near, far], in order: visit(i, from, to)
/// until it returns false. The stretches follow each other without a gap, the first from near, the
/// last to far; some may be of no length. A 3D-DDA (Amanatides, Woo 1987), its crossings computed
/// from the planes, not added up, so that long rays do not drift.
template <class Visit>
void for_each_macrocell(const MacrocellGrid& grid, const Ray& ray, double near, double far,
                        Visit&& visit) {
  if (!(near <= far))
    return;
  const math::Vec3d& o = ray.origin;
  const math::Vec3d& d = ray.direction;
  int layer[3];
  double next[3]; // where the ray leaves the layer
  const auto crossing = [&](int a) {
    if (d[a] > 0 && layer[a] + 1 < grid.counts[a])
      return (grid.plane(a, layer[a] + 1) - o[a]) / d[a];
    if (d[a] < 0 && layer[a] > 0)
      return (grid.plane(a, layer[a]) - o[a]) / d[a];
    return double(HUGE_VAL);
  };
  for (int a = 0; a < 3; ++a) {
    layer[a] = grid.layer(a, o[a] + near * d[a]);
    next[a] = crossing(a);
  }
  double from = near;
  for (;;) {
    const int a = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
    const double to = next[a] < far ? (next[a] > from ? next[a] : from) : far;
    if (!visit(grid.index(layer[0], layer[1], layer[2]), from, to) || !(next[a] < far))
      return;
    from = to;
    layer[a] += d[a] > 0 ? 1 : -1;
    next[a] = crossing(a);
  }
}

} // namespace insitu::render

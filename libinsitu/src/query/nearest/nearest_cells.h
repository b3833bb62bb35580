#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "core/parallel.h"
#include "geo/chart.h"
#include "mesh/box.h"
#include "query/directory.h"
#include "query/nearest/nearest_on_cell.h"
#include "query/sampler.h"

/// What lies nearest to a place, on the same trees that answer which cell holds it.
namespace insitu::query {

/// A place of a geodetic mesh has several images among the cells: a turn farther west and east, and
/// on a chart turned to its pole. Any other place has one.
struct Images {
  math::Vec3d at[4];
  Metric metric[4];
  int count = 0;

  Images(const math::Vec3d& p, const ChartImage* chart);
  /// The squared length of the way to a place of the mesh's frame, the short way round. Near a
  /// pole it is that on the turned chart: degrees of longitude are short at the place alone.
  double squared_to(const math::Vec3d& x) const;
  /// Whether image i is a plain one near a pole: lengths there are too short, never too long.
  bool is_skewed(int i) const { return i < 3 && count == 4; }

private:
  const ChartImage* chart_;
  geo::Pole pole_ = geo::Pole::none; ///< of the last image, if there are four
};

/// The cell nearest to a place, of a process's own.
struct NearestCell {
  double squared = std::numeric_limits<double>::infinity(); ///< of the distance
  Location at;       ///< the cell, as Sampler counts cells, and where in it; outside: none
  math::Vec3d point; ///< the nearest point, where the cells are (on a chart: an image)
};

class NearestCells {
public:
  /// sampler: own_sampler() of a committed mesh, which must outlive the object. Fits the tree, if
  /// that waits.
  explicit NearestCells(const Sampler& sampler);

  /// p: a place in the mesh's frame that no cell holds. Cells farther than `farthest` do not
  /// answer. Of cells at one distance that with the lowest flat id answers.
  NearestCell find(const math::Vec3d& p, double farthest) const;
  /// The same of some, in parallel; found has as many items.
  void find(const core::Threads& threads, std::span<const math::Vec3d> points, double farthest,
            std::span<NearestCell> found) const;

private:
  void look(const Images& images, int i, double farthest, NearestCell& best) const;
  void look_at_item(std::int64_t first, const Images& images, int i, double farthest,
                    NearestCell& best) const;

  const Sampler sampler_;
  const accel::Tree& tree_;
};

/// Visits the items of a tree that may lie within reach of a place, near ones before far ones.
/// reach(): the squared distance that still counts, which may shrink; visit(flat).
void visit_near(const accel::Tree& tree, const math::Vec3d& image, const Metric& metric,
                core::FunctionRef<double()> reach, core::FunctionRef<void(std::int64_t)> visit);

/// Adds the ranks of the processes that have cells near a place, none farther than `farthest`.
/// nearest_alone: only those that may have the nearest one.
void add_ranks_near(const Directory& directory, const Images& images, double farthest,
                    bool nearest_alone, std::vector<int>& ranks);

} // namespace insitu::query

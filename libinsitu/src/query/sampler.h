#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <span>

#include "accel/morton/sort.h"
#include "cells/exact/decide.h"
#include "core/parallel.h"
#include "math/vec.h"
#include "mesh/view.h"

namespace insitu::accel {
class FaceNeighbours;
class Tree;
} // namespace insitu::accel

namespace insitu::query {

class Adaptive;
class CulledCells;
class Locators;
class SpatialOrder;
struct ChartImage;

/// The owner of a point: flat cell id (see mesh::MeshView), or -1 outside, and VTK's parametric
/// coordinates in it.
struct Location {
  std::int64_t cell = -1;
  math::Vec3d parametric;
  explicit operator bool() const { return cell >= 0; }
};

using cells::Reason;
using cells::reason_count;

struct LocateOptions {
  /// They differ only where cells overlap without folding; see insitu_accuracy.
  insitu_accuracy accuracy = INSITU_STANDARD;
  /// Coordinates between the earlier (0) and the current step (1); needs MeshView::earlier_points
  /// unless 1.
  double alpha = 1.0;
  /// Whether parametric coordinates and reasons are asked for; false: cells alone. Coordinates then
  /// may be 0, and where only Newton's method tells whether a cell is proven (`fast` by rays) it
  /// does not run and the reason is on_face.
  bool coordinates = true;
};

/// Answers of some points of a batch: those of points[item(k)], for k below locations.size().
struct Answered {
  std::span<const Location> locations;
  std::span<const Reason> reasons;
  std::size_t first = 0;                       ///< added to the items
  const accel::morton::Coded* order = nullptr; ///< [locations.size()] of the items; null: 0, 1, ...
  /// Locations that were found one by one; the others lie in gridlets, many next to each other.
  /// Empty where nobody knows.
  std::span<const std::uint16_t> one_by_one = {};

  std::size_t item(std::size_t k) const { return first + (order ? order[k].id : k); }
};

/// How many points were located for which reason. Thread-safe.
class LocateCounts {
public:
  void add(const std::int64_t (&by_reason)[reason_count]);
  void add(Reason reason);
  std::array<std::int64_t, reason_count> totals() const;

  /// Points, among those counted, that particles asked for because no neighbour was known of the
  /// cell that they were in; see CommittedMesh::find_neighbours_if_due().
  void add_unguided(std::int64_t points) { unguided_.fetch_add(points, std::memory_order_relaxed); }
  std::int64_t unguided() const { return unguided_.load(std::memory_order_relaxed); }

private:
  /// A few copies, a cache line each, so that threads do not wait for each other.
  struct alignas(64) Copy {
    std::atomic<std::int64_t> by_reason[reason_count] = {};
  };
  static constexpr std::size_t copy_count = 16;
  Copy& mine();
  Copy copies_[copy_count];
  std::atomic<std::int64_t> unguided_{0};
};

/// How batches by a ray method were answered, in points; not those in `fast`, which proves nothing.
/// Thread-safe.
struct RayCounts {
  std::atomic<std::int64_t> kept{0};         ///< the cell that the rays told, proven
  std::atomic<std::int64_t> by_neighbour{0}; ///< the cell beyond the face that was hit, proven
  std::atomic<std::int64_t> by_tree{0};      ///< through the tree, outside ones included
};

/// Answers point queries on a committed mesh. Cheap to copy; valid until the next commit. All calls
/// are const, and their answers do not depend on threads or batching. All but the parallel
/// batch are thread-safe.
class Sampler {
public:
  /// order, counts: may be null; then batches are taken in their own order, and nothing is counted.
  /// locators: batches go by its ray method first (RayBatch), parallel ones by its device; null: by
  /// the tree alone, as single points always do. The answers are the same but in `fast`.
  /// adaptive: of which these are the cells, most of which then need no tree; or null.
  /// chart: of a geodetic mesh; points are in its frame, and located by their images; or null.
  /// neighbours: of the mesh's cells, for callers that go from cell to cell; or null.
  Sampler(const mesh::MeshView& mesh, const accel::Tree& tree, SpatialOrder* order = nullptr,
          LocateCounts* counts = nullptr, const Locators* locators = nullptr,
          const Adaptive* adaptive = nullptr, const ChartImage* chart = nullptr,
          const accel::FaceNeighbours* neighbours = nullptr)
      : mesh_(&mesh), tree_(&tree), order_(order), counts_(counts), locators_(locators),
        adaptive_(adaptive), chart_(chart), neighbours_(neighbours) {}

  const mesh::MeshView& mesh() const { return *mesh_; }
  const accel::Tree& tree() const { return *tree_; }
  const ChartImage* chart() const { return chart_; }
  const accel::FaceNeighbours* neighbours() const { return neighbours_; }
  /// The same for points that are images already (ChartImage); vectors in cells on a turned chart
  /// then come out along its own east and north.
  Sampler among_images() const {
    Sampler s = *this;
    s.chart_ = nullptr;
    return s;
  }

  /// The same on other cells, by their tree alone; both must outlive it.
  Sampler in(const mesh::MeshView& cells, const accel::Tree& tree) const {
    return {cells, tree, order_, counts_, nullptr, nullptr, chart_, nullptr};
  }

  /// The same for points of which only those in some cells matter; all others come out as outside.
  /// The cells must outlive it, and be made of this sampler.
  Sampler among(const CulledCells& cells) const;

  /// The lowest flat cell id of the closed cells that hold p. hint: a cell to try first, or -1;
  /// it changes the time, not the answer, unless cells overlap without folding: then the hint's
  /// cell may answer, and in standard any that holds p.
  Location locate(const math::Vec3d& p, std::int64_t hint = -1, const LocateOptions& options = {},
                  Reason* reason = nullptr) const;

  /// Counts points that a caller has located itself, each proven to be strictly inside its cell.
  void count_certified(std::int64_t points) const;
  /// Counts points as LocateCounts::add_unguided().
  void count_unguided(std::int64_t points) const {
    if (counts_ && points > 0)
      counts_->add_unguided(points);
  }

  /// The same for a batch, in parallel; points and locations have the same size, and reasons has it
  /// or is empty. reasons say how this call decided.
  void locate(const core::Threads& threads, std::span<const math::Vec3d> points,
              std::span<Location> locations, const LocateOptions& options = {},
              std::span<std::uint8_t> reasons = {}) const;

  /// Receives answers; from any thread, each point's once, in any order.
  using Put = core::FunctionRef<void(const Answered& answered)>;

  /// The same, answers given to put as soon as they are there, while the owners' data is still in
  /// the cache. Points whose neighbours lie far apart in space are taken in spatial order, which is
  /// why the memory behind `order` serves one call at a time.
  void visit(const core::Threads& threads, std::span<const math::Vec3d> points,
             const LocateOptions& options, Put put) const;

  /// The same on the calling thread alone (for callers that are inside a parallel_for), in the
  /// points' order.
  void locate_serial(std::span<const math::Vec3d> points, std::span<Location> locations,
                     const LocateOptions& options = {}, std::span<std::uint8_t> reasons = {}) const;

  /// The field's components at a location (which must be inside): shape functions for vertex
  /// fields, the cell's value for cell fields. Vectors in cells on a turned chart of a geodetic
  /// mesh come out along the true east and north there.
  void interpolate(const mesh::FieldView& field, const Location& at, double* values) const;

  /// Several fields at one location, the cell's ids and weights found once. values holds the
  /// fields' components one after the other.
  void interpolate(std::span<const mesh::FieldView> fields, const Location& at,
                   double* values) const;

  /// Whether values of these fields take more than the cell of a point: LocateOptions::coordinates.
  bool takes_coordinates(std::span<const mesh::FieldView> fields) const;
  /// The fields at the answers of visit(), into an array a field, each [count][components of the
  /// field]; NaN where there is no owner. first: added to the items.
  void interpolate(std::span<const mesh::FieldView> fields, const Answered& answered,
                   std::size_t first, double* const* values) const;

  /// The gradient, in physical space, of one component of a vertex field within the location's
  /// cell (zero for cell fields). alpha as in LocateOptions.
  math::Vec3d gradient(const mesh::FieldView& field, int component, const Location& at,
                       double alpha = 1.0) const;

private:
  friend class RayBundleLocator;
  bool owns(std::int64_t flat) const;
  void visit_on_device(const core::Threads& threads, std::span<const math::Vec3d> points,
                       const LocateOptions& options, Put put) const;
  void to_true_axes(const mesh::PieceView& cells, std::span<const double> weights,
                    const std::int64_t* ids, double* vector) const;
  template <class Fields, class ValuesOf>
  void interpolate_to(const Fields& fields, std::int32_t piece, const Location& at,
                      ValuesOf&& values_of) const;

  const mesh::MeshView* mesh_;
  const accel::Tree* tree_;
  SpatialOrder* order_;
  LocateCounts* counts_;
  const Locators* locators_;
  const Adaptive* adaptive_;
  const ChartImage* chart_;
  const accel::FaceNeighbours* neighbours_;
  const std::uint64_t* shown_ = nullptr; ///< see DualFinder
};

} // namespace insitu::query

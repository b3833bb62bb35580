#pragma once

#include <cstdint>
#include <span>

#include "mesh/facts.h"
#include "query/point_locator.h"

namespace insitu::accel {
class FaceNeighbours;
class OddSlots;
class Tree;
} // namespace insitu::accel

namespace insitu::query {

class CulledCells;
class LoneCells;
class Outlook;
class Seams;
class SoundCells;
class SpatialOrder;
struct ChartImage;
struct OnDemand;
struct PointQuery;

/// Answers point queries on a committed mesh. Cheap to copy; valid until the next commit. All calls
/// are const, and their answers do not depend on threads or batching. All but the parallel
/// batch are thread-safe.
class Sampler {
public:
  /// order: scratch of batches, which without it (null) are taken in their own order. counts: what
  /// the answers are counted in, or null. locator: how points find their cells; null: by the tree.
  /// chart: of a geodetic mesh, whose points are located by their images; else null. neighbours:
  /// of the mesh's cells, for callers that go from cell to cell, where they are known; else null.
  /// on_demand: where what the mesh finds out when first asked is kept, and the tree's fit, if it
  /// waits; null: the tree is fitted, and the rest is found each time.
  Sampler(const mesh::MeshView& mesh, const accel::Tree& tree, SpatialOrder* order = nullptr,
          LocateCounts* counts = nullptr, const PointLocator* locator = nullptr,
          const ChartImage* chart = nullptr, const accel::FaceNeighbours* neighbours = nullptr,
          const OnDemand* on_demand = nullptr);

  /// The same where cells of other processes are beside the mesh's own: a point on several cells is
  /// owned by the first of all of them. null: by the lowest flat id. seams must outlive it.
  Sampler at(const Seams* seams) const {
    Sampler s = *this;
    s.seams_ = seams;
    return s;
  }

  /// Null unless given by at().
  const Seams* seams() const { return seams_; }

  const mesh::MeshView& mesh() const { return *mesh_; }
  /// The tree, whose boxes are fitted now if that was put off, as the displacement that makes
  /// queries between two steps wider. May throw for want of memory, or
  /// INSITU_ERROR_MESH.
  const accel::Tree& tree() const;
  /// What the tree marks as odd. Asks for no fit.
  const accel::OddSlots& odd() const;
  const OnDemand* on_demand() const { return on_demand_; }
  const PointLocator& locator() const { return *locator_; }
  /// Where it is not known of all cells whether they fold, those that are found to be sound when
  /// they are asked for, which answer alone for a particle that comes from them or from beside
  /// them; null: ProofRule says when cells do. moves: for geometry between two steps.
  const SoundCells* sound_cells(bool moves) const;
  /// The query of points with these options, where the tree is fitted now as by tree().
  PointQuery point_query(const LocateOptions& options) const;
  /// Of the mesh as a whole, found when first asked for; bounds end where a chart does. threads:
  /// null: on the calling thread.
  mesh::MeshFacts facts(const core::Threads* threads = nullptr) const;
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
  Sampler in(const mesh::MeshView& cells, const accel::Tree& tree,
             const OnDemand* on_demand = nullptr) const {
    Sampler s(cells, tree, order_, counts_, nullptr, chart_, nullptr, on_demand);
    s.seams_ = seams_;
    s.outlook_ = outlook_;
    return s;
  }
  /// The same on a view that has these cells, by the same flat ids, and others behind them, which
  /// an outlook alone finds. It must outlive this.
  Sampler on(const mesh::MeshView& view) const {
    Sampler s = *this;
    s.mesh_ = &view;
    return s;
  }
  /// The same, of whose points that no cell holds the outlook is asked by locate() of one point
  /// (and may throw Elsewhere there), by its image on a chart; null: nobody. It must outlive this.
  Sampler with_outlook(const Outlook* outlook) const {
    Sampler s = *this;
    s.outlook_ = outlook;
    return s;
  }
  const Outlook* outlook() const { return outlook_; }

  /// The same for points of which only those in some cells matter; all others come out as outside.
  /// The cells must outlive it, and be made of this sampler.
  Sampler among(const CulledCells& cells) const;

  /// The lowest flat cell id of the closed cells that hold p. hint: a cell to try first, or -1;
  /// it changes the time, not the answer, unless cells overlap without folding: then the hint's
  /// cell may answer, and in standard any that holds p.
  Location locate(const math::Vec3d& p, std::int64_t hint = -1, const LocateOptions& options = {},
                  Reason* reason = nullptr) const;

  /// Counts points that a caller has located itself, by reason.
  void count(const std::int64_t (&by_reason)[reason_count]) const {
    if (counts_)
      counts_->add(by_reason);
  }
  /// The same for points each of which is proven to be strictly inside its cell.
  void count_certified(std::int64_t points) const { count(Reason::certified, points); }
  /// The same for points each of which is on its cell's boundary, or beside it by rounding.
  void count_on_faces(std::int64_t points) const { count(Reason::on_face, points); }
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

  /// The same, answers given to put as soon as they are there, while the owners' data is still in
  /// the cache. Points whose neighbours lie far apart in space are taken in spatial order, which is
  /// why the memory behind `order` serves one call at a time.
  void visit(const core::Threads& threads, std::span<const math::Vec3d> points,
             const LocateOptions& options, PutAnswers put) const;

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

  /// Whether a cell is located and evaluated, as those of a halo are; whether it owns points, which
  /// those do not.
  bool exists(std::int64_t flat) const;
  bool owns(std::int64_t flat) const;

private:
  /// Which cells are alone, if it counts in a query; else null.
  const LoneCells* lone_cells(const LocateOptions& options) const;
  void count(Reason reason, std::int64_t points) const;
  void visit_in_order(Batches& batches, std::span<const math::Vec3d> points, std::size_t count,
                      Batches::Put put) const;
  bool settle_at_seam(const math::Vec3d& p, const LocateOptions& options, Location& at,
                      Reason& reason) const;
  Answered settle_at_seams(const Answered& answered, std::span<const math::Vec3d> points,
                           const LocateOptions& options) const;
  void visit_sorted(Batches& batches, std::span<const math::Vec3d> points,
                    std::span<const accel::morton::Coded> order, PutAnswers put) const;
  void to_true_axes(const mesh::PieceView& cells, std::span<const double> weights,
                    const std::int64_t* ids, double* vector) const;
  template <class Fields, class ValuesOf>
  void interpolate_to(const Fields& fields, std::int32_t piece, const Location& at,
                      ValuesOf&& values_of) const;

  const mesh::MeshView* mesh_;
  const accel::Tree* tree_;
  SpatialOrder* order_;
  LocateCounts* counts_;
  const PointLocator* locator_;
  const ChartImage* chart_;
  const accel::FaceNeighbours* neighbours_;
  const OnDemand* on_demand_;
  const Seams* seams_ = nullptr;
  const Outlook* outlook_ = nullptr;
};

} // namespace insitu::query

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "commit/halo/halo.h"
#include "parallel/bytes.h"
#include "query/location.h"
#include "query/nearest/nearest_vertices.h"

namespace insitu::commit {

class CommittedMesh;

/// The owner of a point among the cells of all processes.
struct OwnerOfAll {
  CellName cell;
  math::Vec3d parametric;
  query::Reason reason = query::Reason::outside;
  explicit operator bool() const { return cell.rank >= 0; }
  /// False: the cell is the nearest one to a point that no cell holds.
  bool holds() const { return reason != query::Reason::outside; }
};

/// How near that is.
struct NearnessOfAll {
  double squared = 0.0; ///< of the distance
  math::Vec3d place;    ///< the nearest point of the owner, in the mesh's frame
};

/// Answers points that any process may hold. Each process asks those whose boxes hold a point
/// (query::Directory), and the least of the cells that they name is the owner (CellName). All calls
/// are collective and throw parallel::AgreedError.
class Everywhere {
public:
  /// The mesh must be committed on all processes, in longitude and latitude with the whole mesh's
  /// chart (CommittedMesh::update_chart), and outlive the object.
  Everywhere(const CommittedMesh& mesh, parallel::World& world);

  /// How many components each field has on the processes that have cells. Throws
  /// INSITU_ERROR_FIELD, by name, for one that no process has.
  std::vector<int> components(std::span<const std::string> fields);

  /// Gives the owner of each point of this process, which may have none, and the fields' values
  /// there, one after the other (null where nobody owns the point): put(first, owners, values) for
  /// slices of the points, each as soon as it is answered.
  using Put = core::FunctionRef<void(std::size_t first, std::span<const OwnerOfAll> owners,
                                     std::span<const double> values)>;
  void sample(std::span<const math::Vec3d> points, std::span<const std::string> fields,
              const query::LocateOptions& options, const core::Threads& threads, Put put);

  /// The same of points that no cell holds: the nearest cell of all processes, if it is no farther
  /// than `farthest`, and of those at one distance the least. All processes give one `farthest`.
  using PutNearest = core::FunctionRef<void(std::size_t first, std::span<const OwnerOfAll> owners,
                                            std::span<const NearnessOfAll> nearness,
                                            std::span<const double> values)>;
  void nearest(std::span<const math::Vec3d> points, std::span<const std::string> fields,
               double farthest, const core::Threads& threads, PutNearest put);

  /// And the nearest vertices of all processes: visit(i, found) at the end.
  using VisitVertices =
      core::FunctionRef<void(std::size_t i, const std::vector<query::NearVertex>& found)>;
  void nearest_vertices(std::span<const math::Vec3d> points, std::size_t most, double farthest,
                        const core::Threads& threads, VisitVertices visit);

private:
  /// What processes answered about points: of parcel p those of items[parcel's rank].
  struct Answers {
    std::vector<std::vector<std::uint32_t>> items; ///< [rank]
    std::vector<parallel::Parcel> parcels;
  };
  /// Adds the ranks of the processes that are asked about a point.
  using RanksOf = core::FunctionRef<void(const math::Vec3d& point, std::vector<int>& ranks)>;
  using Answer = core::FunctionRef<std::vector<std::byte>(std::span<const math::Vec3d> points)>;
  Answers ask(std::span<const math::Vec3d> points, RanksOf ranks_of, Answer answer);
  using Slice = core::FunctionRef<void(std::size_t first, std::span<const math::Vec3d> points)>;
  void for_each_slice(std::span<const math::Vec3d> points, Slice slice);
  std::vector<mesh::FieldView> fields_here(std::span<const std::string> names) const;
  void sample_slice(std::size_t first, std::span<const math::Vec3d> points,
                    std::span<const std::string> fields, std::size_t width,
                    const query::LocateOptions& options, const core::Threads& threads, Put put);
  std::vector<std::byte> answer(std::span<const math::Vec3d> points,
                                std::span<const std::string> fields,
                                const query::LocateOptions& options, const core::Threads& threads);
  void nearest_slice(std::size_t first, std::span<const math::Vec3d> points,
                     std::span<const std::string> fields, std::size_t width, double farthest,
                     const core::Threads& threads, PutNearest put);
  std::vector<std::byte> answer_nearest(std::span<const math::Vec3d> points,
                                        std::span<const std::string> fields, double farthest,
                                        const core::Threads& threads);

  const CommittedMesh& mesh_;
  parallel::World& world_;
  query::Directory directory_;
};

} // namespace insitu::commit

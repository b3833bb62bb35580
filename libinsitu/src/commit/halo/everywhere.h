#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "commit/halo/halo.h"
#include "query/location.h"

namespace insitu::commit {

class CommittedMesh;

/// The owner of a point among the cells of all processes.
struct OwnerOfAll {
  CellName cell;
  math::Vec3d parametric;
  query::Reason reason = query::Reason::outside;
  explicit operator bool() const { return reason != query::Reason::outside; }
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

private:
  void sample_slice(std::size_t first, std::span<const math::Vec3d> points,
                    std::span<const std::string> fields, std::size_t width,
                    const query::LocateOptions& options, const core::Threads& threads, Put put);
  std::vector<std::byte> answer(std::span<const std::byte> question,
                                std::span<const std::string> fields,
                                const query::LocateOptions& options, const core::Threads& threads);

  const CommittedMesh& mesh_;
  parallel::World& world_;
  query::Directory directory_;
};

} // namespace insitu::commit

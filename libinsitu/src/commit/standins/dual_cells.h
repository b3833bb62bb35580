#pragma once

#include <memory>
#include <string>
#include <vector>

#include "amr/dual/dual_mesh.h"
#include "commit/standins/dual_order.h"
#include "commit/standins/gathered_fields.h"
#include "mesh/registered/mesh.h"
#include "query/lattice/gridlet_places.h"

namespace insitu::commit {

/// An adaptive mesh's dual in place of its cells. Fields are gathered from the solver's arrays to
/// the dual's vertices when they are first asked for after a commit, in the solver's precision.
class DualCells {
public:
  explicit DualCells(core::Memory& memory);
  ~DualCells();

  /// Of a mesh that is spread over processes, which all build at once.
  struct Neighbours {
    parallel::World& world;
    std::span<const amr::LentLeaf> lent;
    const std::uint64_t* outermost; ///< see amr::SharedLeaves
    /// Whether a leaf comes before another one in the order of all processes; by flat ids.
    core::FunctionRef<bool(std::uint32_t, std::uint32_t)> is_before;
  };
  /// At a regrid. Throws INSITU_ERROR_MESH; the object then must not be used. The mesh and the
  /// threads must outlive it: fields are gathered later.
  void build(const mesh::Mesh& mesh, const core::Threads& threads,
             amr::Cubes cubes = amr::Cubes::counts, const Neighbours* neighbours = nullptr);
  /// The solver's values changed: what was gathered is stale.
  void fields_changed();

  const amr::DualMesh& dual() const { return dual_; }
  /// Empty unless dual().has_gridlets().
  const query::GridletPlaces& places() const { return places_; }

  /// Of a mesh that is spread over processes.
  const DualOrder& order() const { return order_; }
  /// Of a cell that exists, the first of its leaves, which says whose it is.
  std::uint32_t first_leaf(std::int64_t flat,
                           core::FunctionRef<bool(std::uint32_t, std::uint32_t)> is_before) const;

  const mesh::MeshView& view() const { return dual_.view(); }
  /// Thread-safe.
  mesh::FieldView field(const mesh::FieldView& own);

private:
  struct Gathered;
  void gather(const mesh::FieldView& own, Gathered& to) const;
  int leaves_of(std::int64_t flat, std::uint32_t* leaves) const; ///< of its vertices; how many
  void find_owners(const Neighbours& neighbours);

  core::Memory* memory_;
  amr::DualMesh dual_;
  query::GridletPlaces places_;
  DualOrder order_;
  core::Buffer<std::uint64_t> foreign_[2]; ///< a bit a cell of each piece: another process owns it
  const mesh::MeshView* own_ = nullptr;
  const mesh::AmrView* amr_ = nullptr;
  const core::Threads* threads_ = nullptr;
  GatheredFields<Gathered> fields_;
};

} // namespace insitu::commit

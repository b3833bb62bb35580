#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "amr/dual/dual_mesh.h"
#include "mesh/registered/mesh.h"
#include "query/lattice/gridlet_places.h"

namespace insitu::commit {

/// An adaptive mesh's dual in place of its cells. Fields are gathered from the solver's arrays to
/// the dual's vertices when they are first asked for after a commit, in the solver's precision.
class DualCells {
public:
  explicit DualCells(core::Memory& memory);
  ~DualCells();

  /// At a regrid. Throws INSITU_ERROR_MESH; the object then must not be used. The mesh and the
  /// threads must outlive it: fields are gathered later.
  void build(const mesh::Mesh& mesh, const core::Threads& threads,
             amr::Cubes cubes = amr::Cubes::counts);
  /// The solver's values changed: what was gathered is stale.
  void fields_changed();

  const amr::DualMesh& dual() const { return dual_; }
  /// Empty unless dual().has_gridlets().
  const query::GridletPlaces& places() const { return places_; }

  const mesh::MeshView& view() const { return dual_.view(); }
  /// Thread-safe.
  mesh::FieldView field(const mesh::FieldView& own);

private:
  struct Gathered;
  void gather(const mesh::FieldView& own, Gathered& to) const;

  core::Memory* memory_;
  amr::DualMesh dual_;
  query::GridletPlaces places_;
  const mesh::MeshView* own_ = nullptr;
  const core::Threads* threads_ = nullptr;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Gathered>> fields_;
};

} // namespace insitu::commit

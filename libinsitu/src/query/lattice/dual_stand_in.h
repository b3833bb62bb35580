#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "amr/dual/dual_mesh.h"
#include "mesh/registered/mesh.h"
#include "query/lattice/gridlet_places.h"

namespace insitu::query {

/// An adaptive mesh's dual in place of its cells. Fields are gathered from the solver's arrays to
/// the dual's vertices when they are first asked for after a commit, in the solver's precision.
class DualStandIn final : public mesh::StandIn {
public:
  explicit DualStandIn(core::Memory& memory);
  ~DualStandIn() override;

  /// At a regrid. Throws INSITU_ERROR_MESH; the stand-in then must not be used. The mesh and the
  /// threads must outlive it: fields are gathered later.
  void build(const mesh::Mesh& mesh, const core::Threads& threads);
  /// The solver's values changed: what was gathered is stale.
  void fields_changed();

  const amr::DualMesh& dual() const { return dual_; }
  const GridletPlaces& places() const { return places_; }
  std::int64_t value_bytes() const;

  const mesh::MeshView& view() const override { return dual_.view(); }
  /// Thread-safe.
  mesh::FieldView field(const mesh::FieldView& own) override;

private:
  struct Gathered;
  void gather(const mesh::FieldView& own, Gathered& to) const;

  core::Memory* memory_;
  amr::DualMesh dual_;
  GridletPlaces places_;
  const mesh::MeshView* own_ = nullptr;
  const core::Threads* threads_ = nullptr;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<Gathered>> fields_;
};

} // namespace insitu::query

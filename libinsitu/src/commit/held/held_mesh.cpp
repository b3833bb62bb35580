#include "commit/held/held_mesh.h"

#include "core/status.h"

namespace insitu::commit {

namespace {

/// Of what the solver's mesh has told already.
core::Log silent() {
  return {insitu_log_level(0), nullptr, nullptr};
}

} // namespace

HeldMesh::HeldMesh(const CommittedMesh& of, core::Memory& memory)
    : memory_(&memory), of_(&of), of_id_(of.id()), topology_(of.own_topology_version()),
      geometry_(of.geometry_version()), cells_(memory), mesh_(of.mesh().name(), memory) {
  if (of.lies_on_device())
    throw core::Error(INSITU_ERROR_UNSUPPORTED,
                      "mesh '" + of.mesh().name() +
                          "' lies in device memory; steps are held of meshes in host memory");
}

bool HeldMesh::copy(const mesh::ValuesGiven& values, const core::Threads& threads) {
  mesh_.begin_copy(*of_);
  cells_.copy(of_->mesh(), mesh_.mesh(), threads);
  return put(values, threads);
}

void HeldMesh::meet(parallel::World& world, const core::Threads& threads) {
  if (of_->needs_halo(world))
    mesh_.update_halo(world, threads, silent());
  else
    mesh_.update_chart(world, threads, silent());
  mesh_.end_copy();
  of_ = nullptr;
}

bool HeldMesh::put(const mesh::ValuesGiven& values, const core::Threads& threads) {
  if (values_ == &values)
    return false;
  values_ = nullptr; // until all are in
  values.give(mesh_.mesh());
  const insitu_commit_report report = mesh_.commit(threads, silent(), *memory_, false);
  values_ = &values;
  return report.action == INSITU_REBUILD;
}

void HeldMesh::forget(const mesh::ValuesGiven& values) {
  if (values_ == &values)
    values_ = nullptr;
}

bool HeldMesh::is_of(const CommittedMesh& mesh) const {
  return of_id_ == mesh.id() && topology_ == mesh.own_topology_version() &&
         geometry_ == mesh.geometry_version();
}

} // namespace insitu::commit

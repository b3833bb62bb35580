#include "query/committed_mesh.h"

#include <algorithm>

#include "cells/conformity.h"
#include "core/status.h"
#include "core/timer.h"
#include "query/hanging_vertices.h"
#include "query/overlaps.h"
#include "query/point_query.h"

namespace insitu::query {

CommittedMesh::CommittedMesh(const std::string& name, core::Memory& memory)
    : memory_(&memory), mesh_(name, memory), tree_(memory), order_(memory) {}

void CommittedMesh::set_locator(accel::Method method) {
  if (method == method_)
    return;
  method_ = method;
  rays_.reset();
  faces_.reset();
  if (method != accel::Method::bvh)
    mesh_.set_changed(INSITU_CHANGED_TOPOLOGY);
}

void CommittedMesh::require_committed() const {
  if (!committed_)
    throw core::Error(INSITU_ERROR_ORDER, "mesh '" + mesh_.name() +
                                              "' is not committed; call insitu_mesh_commit first");
  if (mesh_.pending() != 0)
    throw core::Error(INSITU_ERROR_ORDER, "mesh '" + mesh_.name() +
                                              "' changed since its commit; call "
                                              "insitu_mesh_commit first");
}

void CommittedMesh::look_for_folds(const core::Threads& threads) {
  require_committed();
  if (folds_are_known_)
    return;
  folds_are_known_ = true;
  mesh_.set_free_of_folds(cells::is_free_of_folds(mesh_.view(), threads));
  look_for_overlaps(threads);
}

/// Worth its time only to rays: their candidates may then answer alone in `exact`.
void CommittedMesh::look_for_overlaps(const core::Threads& threads) {
  if (!rays_ || !mesh_.view().free_of_folds)
    return;
  if (faces_) {
    mesh_.set_covers_once(covers_once(mesh_.view(), *faces_, tree_, threads));
    return;
  }
  accel::FaceTable faces(*memory_);
  faces.build(mesh_.view(), threads);
  mesh_.set_covers_once(covers_once(mesh_.view(), faces, tree_, threads));
}

/// Builds for a new topology, refits for moved vertices.
void CommittedMesh::update_rays(bool topology, const core::Threads& threads) {
  if (method_ == accel::Method::bvh)
    return;
  mesh_.set_changed(INSITU_CHANGED_TOPOLOGY); // until done, as for the tree
  if (!topology) {
    rays_->refit(mesh_.view(), threads);
    return;
  }
  rays_.reset(); // before the faces that it reads
  faces_.reset();
  if (accel::uses_faces(method_)) {
    faces_ = std::make_unique<accel::FaceTable>(*memory_);
    faces_->build(mesh_.view(), threads);
  }
  rays_ = accel::make_embree_locator(method_, *memory_);
  rays_->build(mesh_.view(), faces_.get(), threads);
}

cells::Validation CommittedMesh::validate(const core::Threads& threads) {
  committed_ = false; // the views may change under the tree
  mesh_.update();
  if (mesh_.pending() == 0)
    mesh_.set_changed(INSITU_CHANGED_FIELDS); // the next commit is cheap, but has to come
  cells::Validation found = cells::validate(mesh_.name(), mesh_.view(), threads);
  if (found.findings.empty()) {
    const cells::Conformity c = cells::check_conformity(mesh_.view(), threads);
    found.counts.coincident_vertices = c.coincident_vertices;
    found.counts.crowded_faces = c.crowded_faces;
    found.counts.split_faces = c.split_faces;
    const HangingVertices v = find_hanging_vertices(mesh_.view(), threads);
    found.counts.hanging_vertices = v.hanging;
    found.counts.covered_vertices = v.covered;
  }
  return found;
}

/// Tells the policy what was asked of the tree since the last commit.
void CommittedMesh::note_queries() {
  std::int64_t located = 0;
  for (const std::int64_t n : locate_counts_.totals())
    located += n;
  located_lately_ = located - located_before_;
  policy_.served(located_lately_, tree_.cost_ratio());
  located_before_ = located;
}

insitu_commit_report CommittedMesh::commit(const core::Threads& threads, const core::Log& log,
                                           const core::Memory& memory, bool strict) {
  const core::Timer timer;
  insitu_commit_report report = insitu_commit_report_default();
  const std::uint32_t pending = mesh_.pending();
  const std::int64_t bytes_before = memory.current();
  if (committed_ && pending == 0) {
    report.seconds = timer.seconds();
  } else {
    committed_ = false;
    mesh_.update();
    if (strict)
      for (const insitu_audit_entry& e : mesh_.audit())
        if (!e.borrowed)
          throw core::Error(INSITU_ERROR_CONVERSION, "mesh '" + mesh_.name() + "', " + e.name +
                                                         ": strict mode refuses a copy (" +
                                                         e.reason + ")");
    note_queries();
    const bool topology = (pending & INSITU_CHANGED_TOPOLOGY) != 0;
    const bool geometry = (pending & INSITU_CHANGED_GEOMETRY) != 0;
    bool rebuild = topology;
    if (topology || geometry)
      mesh_.set_covers_once(false);
    if (topology) {
      policy_.topology_changed();
      const cells::Validation validation = cells::validate(mesh_.name(), mesh_.view(), threads);
      report.validated = 1;
      if (!validation.findings.empty())
        throw core::Error(INSITU_ERROR_MESH, validation.findings);
      if (!validation.warning.empty())
        log.warning(validation.warning);
      folds_are_known_ = true;
      mesh_.set_free_of_folds(cells::is_free_of_folds(mesh_.view(), validation.counts));
      ++topology_version_;
    } else if (geometry) {
      tree_.refit(mesh_.view(), threads);
      folds_are_known_ = false;
      mesh_.set_free_of_folds(false);
      report.action = INSITU_REFIT;
      rebuild = policy_.rebuild_is_due(tree_.cost_ratio());
    }
    rebuild = rebuild || policy_.surface_area_is_due();
    if (rebuild) {
      mesh_.set_changed(INSITU_CHANGED_TOPOLOGY); // until built: a build that fails leaves no tree
      const accel::Builder builder = policy_.builder();
      const core::Timer build_timer;
      tree_.build(mesh_.view(), threads, builder);
      policy_.built(builder, build_timer.seconds(), tree_.cell_count(), tree_.cost());
      report.action = INSITU_REBUILD;
      commits_since_build_ = 0;
    }
    if (topology || geometry)
      update_rays(topology, threads);
    if (topology)
      look_for_overlaps(threads);
    if (rebuild || geometry)
      ++tree_version_;
    ++fields_version_;
    mesh_.clear_pending();
    committed_ = true;
    // Steps are much alike. A search took 60 to 70 ns a hexahedron and saved 30 to 60 a point; 20
    // to 30 a wedge, and saved 50.
    if (geometry &&
        (rays_ || (located_lately_ > 2 * tree_.cell_count() && trying_pays(mesh_.view()))))
      look_for_folds(threads);
  }
  // The builder's scratch is worth keeping only while rebuilds come often.
  constexpr int patience = 4;
  if (report.action != INSITU_REBUILD && ++commits_since_build_ == patience)
    tree_.release_scratch();
  report.seconds = timer.seconds();
  report.cost_ratio = tree_.cost_ratio();
  report.builder = tree_.empty()                                     ? INSITU_BUILDER_NONE
                   : tree_.builder() == accel::Builder::surface_area ? INSITU_BUILDER_SURFACE_AREA
                                                                     : INSITU_BUILDER_MORTON;
  report.cells = mesh_.view().cell_count();
  report.vertices = mesh_.view().vertex_count();
  report.bytes =
      tree_.bytes() + (faces_ ? faces_->bytes() : 0) + (rays_ ? rays_->report().bytes : 0);
  report.bytes_allocated = std::max<std::int64_t>(0, memory.current() - bytes_before);
  return report;
}

} // namespace insitu::query

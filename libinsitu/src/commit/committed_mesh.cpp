#include "commit/committed_mesh.h"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <optional>
#include <utility>

#include "cells/checks/conformity.h"
#include "cells/checks/float_rounding.h"
#include "commit/checks/hanging_vertices.h"
#include "core/status.h"
#include "core/timer.h"
#include "device/available.h"
#include "mesh/registered/earlier_parts.h"
#include "mesh/registered/host_mirror.h"
#include "query/point_query.h"

namespace insitu::commit {

namespace {

std::unique_ptr<mesh::HostMirror> make_mirror(const mesh::Mesh& mesh) {
  return std::make_unique<mesh::HostMirror>(
      mesh, [](std::byte* to, const std::byte* from, std::size_t bytes) {
        device::copy_from_device(to, from, bytes);
      });
}

std::uint64_t next_id() {
  static std::atomic<std::uint64_t> last{0};
  return ++last;
}

} // namespace

CommittedMesh::CommittedMesh(const std::string& name, core::Memory& memory)
    : id_(next_id()), mesh_(name, memory), tree_(memory), locators_(memory), order_(memory),
      memory_(&memory), fit_(tree_, mesh_, policy_, odd_cells_), sound_(memory),
      lone_(tree_, memory), earlier_cells_(memory) {
  on_demand_.tree = &fit_;
  on_demand_.displacement = &displacement_;
  on_demand_.sound = &sound_;
  on_demand_.lone = &lone_;
}

void CommittedMesh::require_a_commit() const {
  if (!committed_)
    throw core::Error(INSITU_ERROR_ORDER, "mesh '" + mesh_.name() +
                                              "' is not committed; call insitu_mesh_commit first");
}

void CommittedMesh::require_committed() const {
  require_a_commit();
  if (mesh_.pending() != 0)
    throw core::Error(INSITU_ERROR_ORDER, "mesh '" + mesh_.name() +
                                              "' changed since its commit; call "
                                              "insitu_mesh_commit first");
}

cells::Validation CommittedMesh::validate(const core::Threads& threads) {
  committed_ = false; // the views may change under the tree
  set_flat_turn();
  mesh_.look_again();
  mesh_.update(&threads);
  if (mesh_.pending() == 0)
    mesh_.set_changed(INSITU_CHANGED_FIELDS); // the next commit is cheap, but has to come
  const std::unique_ptr<mesh::HostMirror> mirror =
      mesh_.lies_on_device() ? make_mirror(mesh_) : nullptr;
  if (const auto stand_in = make_stand_in(mesh_, reference_frame, *memory_))
    if (const auto found = stand_in->validate(mesh_, threads))
      return *found;
  const mesh::MeshView& view = mirror ? mirror->view() : mesh_.view();
  cells::Validation found = cells::validate(mesh_.name(), view, threads);
  if (found.findings.empty()) {
    const cells::Conformity c = cells::check_conformity(view, threads);
    found.counts.coincident_vertices = c.coincident_vertices;
    found.counts.crowded_faces = c.crowded_faces;
    found.counts.split_faces = c.split_faces;
    const HangingVertices v = find_hanging_vertices(view, threads);
    found.counts.hanging_vertices = v.hanging;
    found.counts.covered_vertices = v.covered;
  }
  return found;
}

/// Brings the stand-in up to date. Cells that were made leave with their step before others are.
StandIn::Found CommittedMesh::commit_stand_in(std::uint32_t changed, const core::Threads& threads,
                                              const core::Log& log) {
  if (!stand_in_)
    return {};
  if (is_made() && stand_in_->is_due(mesh_, changed)) {
    mesh_.set_changed(INSITU_CHANGED_TOPOLOGY); // until there are others
    part_from_earlier(threads);
    if (!stand_in_)
      stand_in_ = make_stand_in(mesh_, reference_frame, *memory_);
  }
  return stand_in_->commit(mesh_, reference_frame, changed, threads, log);
}

void CommittedMesh::choose_stand_in() {
  if (stand_in_ && !stand_in_->serves(mesh_, reference_frame)) {
    mesh_.set_stand_in(nullptr);
    stand_in_.reset();
  }
  if (!stand_in_)
    take_chart(stand_in_ = make_stand_in(mesh_, reference_frame, *memory_));
  if (!stand_in_)
    return;
  stand_in_->begin_chart(chart_west);
  stand_in_->require(mesh_.name(), locators_.pick(), on_device_);
}

/// Tells the policy what was asked of the tree since the last commit.
void CommittedMesh::note_queries() {
  const std::int64_t points = located();
  located_lately_ = points - located_before_;
  const std::int64_t drawn = drawn_.exchange(0);
  if (!fit_.is_due()) // else nobody asked the tree
    policy_.served(located_lately_, drawn, tree_.cost_ratio());
  located_before_ = points;
}

/// Own cells are not looked at again for other ones in the halo.
cells::Validation CommittedMesh::validate_cells(const core::Threads& threads) {
  const mesh::MeshView& view = mesh_.view();
  if (stand_in_ || view.halo_piece_count == 0) {
    cells::Validation all = cells::validate(mesh_.name(), view, threads);
    if (!stand_in_)
      own_counts_ = all.counts;
    return all;
  }
  cells::Validation found =
      cells::validate(mesh_.name(), view, threads, view.piece_count - view.halo_piece_count);
  if (!own_counts_) {
    cells::Validation own = cells::validate(mesh_.name(), mesh::own_part(view), threads);
    own_counts_ = own.counts;
    found.findings = std::move(own.findings); // others have told of theirs
    found.warning = std::move(own.warning);
  }
  cells::join(found.counts, *own_counts_);
  return found;
}

/// Throws INSITU_ERROR_MESH for cells that cannot be located in.
void CommittedMesh::accept(const cells::Validation& validation, const mesh::MeshView& view,
                           const core::Threads& threads, const core::Log& log) {
  if (!validation.findings.empty())
    throw core::Error(INSITU_ERROR_MESH, validation.findings);
  // Where depths count downwards, cells that are the right way round are mirrored, all of them.
  const insitu_validation& c = validation.counts;
  const bool mirrored = reference_frame.vertical == INSITU_DOWN &&
                        c.inverted_cells == c.cells - c.ghost_cells &&
                        c.zero_volume_cells + c.folded_cells + c.collapsed_cells == 0;
  if (!in_halo_commit_) { // which has told of its own cells
    if (!validation.warning.empty() && !mirrored)
      log.warning(validation.warning);
    if (const std::string rounding = cells::float_rounding(mesh_.name(), view); !rounding.empty())
      log.warning(rounding);
    if (const std::string& where = mesh_.global_ids_descend(); !where.empty())
      log.warning(where + "; a point on a face of two such cells belongs to the first of them");
  }
  folds_are_known_ = true;
  odd_cells_ = cells::find_odd_cells(view, validation.counts, threads);
  enter_topology(threads);
  sound_.begin(c.inverted_cells >
               c.cells - c.ghost_cells - c.inverted_cells - c.folded_cells - c.zero_volume_cells);
}

/// From here on the cells are others.
void CommittedMesh::enter_topology(const core::Threads& threads) {
  part_from_earlier(threads);
  forget_neighbours();
  on_demand_.facts.forget();
  on_demand_.steps.forget();
  sound_.end();
  lone_.begin(is_as_any() && !lies_on_device());
  ++topology_version_;
  own_topology_version_ += !in_halo_commit_;
}

void CommittedMesh::build_tree(insitu_commit_report& report, const core::Threads& threads) {
  mesh_.set_changed(INSITU_CHANGED_TOPOLOGY); // until built: a build that fails leaves no tree
  fit_.forget();
  const accel::Builder builder = policy_.builder();
  const core::Timer timer;
  tree_.build(mesh_.view(), threads, builder);
  policy_.built(builder, timer.seconds(), tree_.cell_count(), tree_.cost());
  report.action = INSITU_REBUILD;
  commits_since_build_ = 0;
}

std::vector<insitu_audit_entry> CommittedMesh::audit() const {
  std::vector<insitu_audit_entry> entries = mesh_.audit();
  mesh_.audit_flat(entries);
  if (stand_in_)
    stand_in_->audit(entries);
  return entries;
}

void CommittedMesh::commit_on_host(std::uint32_t pending, insitu_commit_report& report,
                                   const core::Threads& threads, const core::Log& log) {
  bool topology = (pending & INSITU_CHANGED_TOPOLOGY) || tree_is_stale_;
  const StandIn::Found found =
      commit_stand_in(topology ? std::uint32_t(INSITU_CHANGED_ALL) : pending, threads, log);
  topology = topology || found.other_cells;
  if (topology) {
    pending |= INSITU_CHANGED_TOPOLOGY; // for the locators
    policy_.topology_changed();
    report.validated = 1;
    if (is_made())
      enter_topology(threads);
    else
      accept(found.validation ? *found.validation : validate_cells(threads), mesh_.view(), threads,
             log);
  }
  const bool other_tree = update_tree(topology, pending, report, threads);
  if (topology)
    tell_overlap(log);
  tree_is_stale_ = false;
  update_locators(pending, threads);
  if (other_tree)
    ++tree_version_;
}

/// Builds or refits the tree, or puts that off, if it is due; true then.
bool CommittedMesh::update_tree(bool topology, std::uint32_t& pending, insitu_commit_report& report,
                                const core::Threads& threads) {
  if (topology && copied_ && take_tree(threads))
    return true;
  if (topology && build_may_wait(threads)) {
    fit_.put_off_build(threads.count());
    report.action = INSITU_REBUILD;
    commits_since_build_ = 0;
    if (!is_made())
      set_odd_cells(std::move(odd_cells_), threads);
    return true;
  }
  bool rebuild = topology;
  const bool refit = !topology && (pending & INSITU_CHANGED_GEOMETRY) != 0;
  if (refit) {
    fit_.put_off(threads.count());
    report.action = INSITU_REFIT;
    if (!fit_may_wait(threads)) {
      fit_.complete();
      report.action = fit_.action();
    }
    if (report.action == INSITU_REBUILD)
      pending |= query::rebuild_due; // boxes that spoil the tree spoil the locators' structures
  }
  rebuild = rebuild || policy_.surface_area_is_due();
  if (rebuild) {
    build_tree(report, threads);
    if (topology && !is_made())
      set_odd_cells(std::move(odd_cells_), threads);
    else
      tree_.mark_odd(mesh_.view(), odd_cells_.ids, threads);
  }
  return rebuild || refit;
}

/// The host reads a copy, and only to validate and to find faces; there is no tree but the
/// device's.
void CommittedMesh::commit_on_device(std::uint32_t pending, insitu_commit_report& report,
                                     const core::Threads& threads, const core::Log& log) {
  std::unique_ptr<mesh::HostMirror> mirror;
  const auto view = [&]() -> const mesh::MeshView& {
    if (!mirror)
      mirror = make_mirror(mesh_);
    return mirror->view();
  };
  tree_is_stale_ = true;
  fit_.forget();
  const bool topology = (pending & INSITU_CHANGED_TOPOLOGY) != 0;
  if (topology) {
    accept(cells::validate(mesh_.name(), view(), threads), view(), threads, log);
    report.validated = 1;
  } else if (!folds_are_known_ && many_were_located()) {
    folds_are_known_ = true;
    odd_cells_ = cells::find_odd_cells(view(), threads);
  }
  if (mesh_.view().piece_count != 1)
    odd_cells_ = {}; // whether pieces lie apart is not known without a tree here
  mesh_.set_free_of_folds(odd_cells_.none());
  report.action = topology || locators_.pending()       ? INSITU_REBUILD
                  : (pending & INSITU_CHANGED_GEOMETRY) ? INSITU_REFIT
                                                        : INSITU_KEEP;
  if (report.action == INSITU_REBUILD)
    locators_.make_faces(view, threads);
  locators_.commit(mesh_, view, pending, threads);
  if (report.action != INSITU_KEEP)
    ++tree_version_;
}

void CommittedMesh::commit_pending(insitu_commit_report& report, const core::Threads& threads,
                                   const core::Log& log, bool strict) {
  const std::uint32_t pending = mesh_.pending();
  committed_ = false;
  displacement_.forget(); // update() hides the earlier step
  on_device_ = mesh_.lies_on_device();
  locators_.decide(on_device_, mesh_.name(), log);
  choose_stand_in();
  set_flat_turn();
  mesh_.update(&threads);
  prepare_flat((pending & INSITU_CHANGED_TOPOLOGY) != 0, log);
  if (strict)
    for (const insitu_audit_entry& e : mesh_.audit())
      if (!e.borrowed)
        throw core::Error(INSITU_ERROR_CONVERSION, "mesh '" + mesh_.name() + "', " + e.name +
                                                       ": strict mode refuses a copy (" + e.reason +
                                                       ")");
  const bool geometry = (pending & INSITU_CHANGED_GEOMETRY) != 0;
  if (geometry || (pending & INSITU_CHANGED_TOPOLOGY)) {
    folds_are_known_ = false;
    odd_cells_ = {};
    mesh_.set_free_of_folds(false);
    if (!tells_one_mesh())
      mesh_.set_one_mesh(false);
    mesh_.set_covers_once(false);
    ++geometry_version_;
    if (!in_halo_commit_)
      own_counts_.reset();
    on_demand_.facts.forget();
    sound_.forget();
    lone_.forget();
  }
  if (lies_on_device())
    commit_on_device(pending, report, threads, log);
  else
    commit_on_host(pending, report, threads, log);
  ++fields_version_;
  own_version_ += pending != 0 && !in_halo_commit_;
  mesh_.clear_pending();
  committed_ = true;
  // Steps are much alike. A search took 60 to 70 ns a hexahedron and saved 30 to 60 a point; 20
  // to 30 a wedge, and saved 50.
  if (geometry && !lies_on_device() && !is_made() && many_were_located() &&
      query::trying_pays(mesh_.view()))
    look_for_folds(threads);
}

insitu_commit_report CommittedMesh::commit(const core::Threads& threads, const core::Log& log,
                                           const core::Memory& memory, bool strict) {
  const core::Timer timer;
  insitu_commit_report report = insitu_commit_report_default();
  const std::uint32_t pending = mesh_.pending();
  const std::int64_t bytes_before = memory.current();
  if (!committed_ || pending != 0 || locators_.pending()) {
    note_queries();
    if (halo_ && mesh_.is_adaptive() && (pending & ~std::uint32_t(INSITU_CHANGED_FIELDS)) != 0)
      mesh_.set_halo(nullptr); // other processes' leaves may lie under new ones
    commit_pending(report, threads, log, strict);
  }
  if (std::exchange(rebuilds_seen_, fit_.done().rebuilds) != fit_.done().rebuilds)
    commits_since_build_ = 0;
  // The builder's scratch is worth keeping only while rebuilds come often.
  constexpr int patience = 4;
  if (report.action != INSITU_REBUILD && ++commits_since_build_ == patience)
    tree_.release_scratch();
  report.seconds = timer.seconds();
  describe(report);
  report.bytes_allocated = std::max<std::int64_t>(0, memory.current() - bytes_before);
  return report;
}

/// The mesh and its tree as they stand.
void CommittedMesh::describe(insitu_commit_report& report) const {
  report.cost_ratio = tree_.cost_ratio();
  const mesh::MeshView& counted = is_copied() || cells_wait() ? mesh_.own_view() : mesh_.view();
  const bool is_due = fit_.lacks_tree() && counted.cell_count() > 0;
  const accel::Builder builder = is_due ? policy_.builder() : tree_.builder();
  report.builder = (tree_.empty() && !is_due) || lies_on_device() ? INSITU_BUILDER_NONE
                   : builder == accel::Builder::surface_area      ? INSITU_BUILDER_SURFACE_AREA
                                                                  : INSITU_BUILDER_MORTON;
  report.cells = counted.own_cell_count();
  report.vertices = mesh_.is_flat() && !mesh_.is_adaptive()
                        ? mesh_.solver_vertex_count()
                        : counted.first_vertex[counted.piece_count - counted.halo_piece_count];
  report.bytes = locators_.info(tree_).bytes;
}

insitu_commit_report CommittedMesh::complete(const core::Memory& memory) {
  require_committed();
  const core::Timer timer;
  const std::int64_t bytes_before = memory.current();
  insitu_commit_report report = insitu_commit_report_default();
  if (fit_.is_due()) {
    fit_.complete();
    report.action = fit_.action();
  }
  report.seconds = timer.seconds();
  describe(report);
  report.bytes_allocated = std::max<std::int64_t>(0, memory.current() - bytes_before);
  return report;
}

} // namespace insitu::commit

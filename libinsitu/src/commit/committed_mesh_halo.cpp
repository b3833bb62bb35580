/// The cells of other processes beside a mesh's own.
#include <algorithm>
#include <bit>

#include "commit/committed_mesh.h"
#include "commit/halo/seam_faces.h"
#include "commit/halo/seam_names.h"
#include "commit/standins/adaptive.h"
#include "core/status.h"

namespace insitu::commit {

using parallel::Reduction;

CellName CommittedMesh::name(std::int64_t flat) const {
  const mesh::MeshView& view = mesh_.own_view();
  const std::int32_t piece = view.piece_of(flat), own = view.piece_count - view.halo_piece_count;
  const std::int64_t cell = flat - view.first_cell[piece];
  if (piece >= own)
    return halo_->name(std::size_t(piece - own), cell);
  return {mesh_.global_id(INSITU_CELL, flat), rank_, piece, cell};
}

std::int64_t CommittedMesh::find(const CellName& name) const {
  const mesh::MeshView& view = mesh_.own_view();
  const std::int32_t own = view.piece_count - view.halo_piece_count;
  if (name.rank == rank_) {
    const bool is_here = name.piece >= 0 && name.piece < own && name.cell >= 0 &&
                         name.cell < view.pieces[name.piece].cell_count;
    return is_here ? view.first_cell[name.piece] + name.cell : -1;
  }
  if (!halo_)
    return -1;
  const auto [piece, cell] = halo_->find(name);
  return cell < 0 ? -1 : view.first_cell[own + std::int32_t(piece)] + cell;
}

CellName CommittedMesh::located_name(std::int64_t flat) const {
  if (!stand_in_)
    return name(flat);
  if (const auto made = mesh_.has_stand_in() ? stand_in_->made_cell(flat) : std::nullopt)
    return {made->number, name(made->owner).rank, 0, 0};
  const StandIn::Place at = stand_in_->place(flat);
  CellName found = name(at.own);
  found.chart = at.chart;
  found.copy = std::max(found.copy, at.copy);
  return found;
}

std::int64_t CommittedMesh::find_located(const CellName& name) const {
  if (is_made() && mesh_.has_stand_in())
    return stand_in_->find_made(name.global);
  const std::int64_t own = find(name);
  return own >= 0 && stand_in_ ? stand_in_->find({own, name.chart, name.copy}) : own;
}

bool CommittedMesh::needs_halo(parallel::World& world) const {
  std::int64_t any = mesh_.is_adaptive() || halo_;
  if (world.size() > 1)
    world.reduce(std::span(&any, 1), Reduction::greatest);
  return world.size() > 1 && any;
}

bool CommittedMesh::NamesAtSeams::is_at_seam(std::int64_t flat) const {
  return flat >= mesh_.mesh_.view().own_cell_count() ||
         mesh_.halo_->is_at_seam(mesh_.stand_in_ ? mesh_.stand_in_->place(flat).own : flat);
}

bool CommittedMesh::NamesAtSeams::is_before(std::int64_t flat, std::int64_t other) const {
  return mesh_.located_name(flat) < mesh_.located_name(other);
}

bool CommittedMesh::lends_field(const std::string& name) const {
  return !lent_fields_named_in || mesh_.is_adaptive() ||
         lent_fields_named_in->find(name) != std::string::npos;
}

void CommittedMesh::join_sides(const PeriodicAxes& sides) {
  for (std::size_t a = 0; a < sides.size(); ++a)
    if (sides[a] && !sides_[a]) {
      sides_[a] = true;
      halo_topology_ = 0;
    }
}

void CommittedMesh::drop_halo() {
  if (!halo_)
    return;
  mesh_.set_halo(nullptr);
  mesh_.set_changed(INSITU_CHANGED_ALL);
  halo_.reset();
}

/// The leaves around this process's, and what is made of both.
void CommittedMesh::update_leaf_halo(parallel::World& world, const core::Threads& threads) {
  world.agree_after([&] {
    if (!mesh_.is_adaptive() && mesh_.own_view().own_cell_count() > 0)
      throw core::Error(INSITU_ERROR_MESH,
                        "mesh '" + mesh_.name() +
                            "' has cells that are not adaptive, and is adaptive elsewhere");
    mesh_.set_halo(nullptr);
    mesh_.set_changed(INSITU_CHANGED_ALL);
    committed_ = false;
    if (stand_in_)
      part_from_earlier(threads);
    choose_stand_in();
    mesh_.update(&threads);
  });
  const auto* const made = dynamic_cast<const Adaptive*>(stand_in_.get());
  halo_->find_leaves(mesh_, made && made->waits() ? &made->leaves() : nullptr, world, threads);
  mesh::Mesh none("", *memory_); // on a process that does not say where it would have leaves
  std::int64_t is_nearest = mesh_.is_adaptive() && mesh_.reconstruction() == INSITU_NEAREST;
  world.reduce(std::span(&is_nearest, 1), Reduction::greatest);
  world.agree_after([&] {
    insitu_amr amr = insitu_amr_default();
    amr.reconstruction = is_nearest != 0 ? INSITU_NEAREST : INSITU_DUAL;
    if (!mesh_.is_adaptive())
      none.set_amr(&amr);
    mesh_.set_halo(halo_.get());
    (mesh_.is_adaptive() ? mesh_ : none).update(&threads);
  });
  std::unique_ptr<Adaptive> other;
  auto* to = dynamic_cast<Adaptive*>(stand_in_.get());
  if (!to) {
    other = std::make_unique<Adaptive>(*memory_);
    to = other.get();
  }
  to->make_on_all(
      mesh_.is_adaptive() ? mesh_ : none, world, *halo_,
      [this](std::uint32_t a, std::uint32_t b) {
        const std::int64_t all = mesh_.own_view().cell_count();
        return a < all && (b >= all || name(a) < name(b));
      },
      threads);
}

void CommittedMesh::update_chart(parallel::World& world, const core::Threads& threads,
                                 const core::Log& log) {
  rank_ = world.rank();
  if (world.size() == 1)
    return;
  std::int64_t is_old = lacks_whole_chart();
  world.reduce(std::span(&is_old, 1), Reduction::greatest);
  if (is_old)
    adopt_whole_chart(world, threads, log);
}

/// Collective.
void CommittedMesh::adopt_whole_chart(parallel::World& world, const core::Threads& threads,
                                      const core::Log& log) {
  const ChartFacts* const mine = stand_in_ ? stand_in_->chart_facts() : nullptr;
  ChartFacts whole = mine ? *mine : ChartFacts{};
  world.reduce(whole.numbers(), Reduction::least);
  const mesh::FlatSlab slab =
      mesh::FlatSlab::of(whole_flat_.any() ? whole_flat_ : mesh_.flat_facts());
  reduce_flat(world);
  world.agree_after([&] {
    const bool other_slab = mesh_.is_flat() && !(slab == mesh::FlatSlab::of(whole_flat_));
    const bool other_chart = stand_in_ && stand_in_->set_whole_chart(whole);
    if (!other_chart && !other_slab)
      return;
    mesh_.set_changed(INSITU_CHANGED_GEOMETRY);
    insitu_commit_report report = insitu_commit_report_default();
    commit_pending(report, threads, log, false);
  });
}

void CommittedMesh::update_halo(parallel::World& world, const core::Threads& threads,
                                const core::Log& log) {
  rank_ = world.rank();
  if (world.size() == 1)
    return;
  std::int64_t any[6];
  const auto compare = [&] {
    const std::int64_t here[] = {(is_made() && !mesh_.is_adaptive()) || on_device_,
                                 !halo_ || halo_topology_ != topology_version_,
                                 halo_geometry_ != geometry_version_,
                                 halo_fields_ != fields_version_,
                                 lacks_whole_chart(),
                                 mesh_.is_adaptive()};
    std::ranges::copy(here, any);
    world.reduce(std::span(any), Reduction::greatest);
  };
  compare();
  if (any[4]) {
    adopt_whole_chart(world, threads, log);
    compare();
  }
  const bool none = any[0], topology = any[1], geometry = any[2], fields = any[3];
  const bool leaves = any[5];
  halo_moves_ = topology ? 0 : halo_moves_ + geometry;
  // Vertices of processes that move them apart are found out, at less and less cost a step.
  const bool looks =
      !none && !leaves &&
      (topology || (geometry && seam_tolerance > 0.0 && std::has_single_bit(halo_moves_)));
  SeamMismatches mismatches;
  try {
    world.agree_after([&] {
      if (none)
        drop_halo();
      else if (!halo_)
        halo_ = std::make_unique<Halo>(*memory_);
    });
    if (!none && leaves && topology)
      update_leaf_halo(world, threads);
    else if (!none && topology)
      halo_->find(*this, sides_, world, threads);
    else if (!none && geometry)
      halo_->refresh_points(*this, world);
    if (!none && (topology || fields))
      halo_->refresh_fields(*this, world);
    world.agree_after([&] {
      mesh_.set_halo(halo_.get());
      if (!none && (topology || geometry || fields))
        mesh_.set_changed(topology ? std::uint32_t(INSITU_CHANGED_ALL)
                          : geometry
                              ? std::uint32_t(INSITU_CHANGED_GEOMETRY | INSITU_CHANGED_FIELDS)
                              : std::uint32_t(INSITU_CHANGED_FIELDS));
      insitu_commit_report report = insitu_commit_report_default();
      in_halo_commit_ = true;
      if (mesh_.pending() != 0)
        commit_pending(report, threads, log, false);
      in_halo_commit_ = false;
      if (looks)
        mismatches = find_seam_mismatches(*this);
    });
    const bool others = !none && topology; // cells
    for (const std::string& what :
         {looks ? commit::describe(mismatches, world) : std::string(),
          looks && others ? describe_twice(mismatches, world) : std::string(),
          leaves && others ? describe_gaps(halo_->gaps(), world) : std::string(),
          others ? describe_wrong_ids(*this, world) : std::string()})
      if (!what.empty() && world.is_root())
        log.warning("mesh '" + mesh_.name() + "': " + what);
  } catch (...) {
    in_halo_commit_ = false;
    drop_halo();
    throw;
  }
  halo_topology_ = topology_version_;
  halo_geometry_ = geometry_version_;
  halo_fields_ = fields_version_;
}

} // namespace insitu::commit

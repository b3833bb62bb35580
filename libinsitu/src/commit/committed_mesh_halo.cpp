/// The cells of other processes beside a mesh's own.
#include <algorithm>

#include "commit/committed_mesh.h"
#include "commit/halo/seam_faces.h"

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

CellName CommittedMesh::name_in_view(std::int64_t flat) const {
  if (!stand_in_)
    return name(flat);
  const StandIn::Place at = stand_in_->place(flat);
  CellName found = name(at.own);
  found.chart = at.chart;
  found.copy = at.copy;
  return found;
}

std::int64_t CommittedMesh::find_in_view(const CellName& name) const {
  const std::int64_t own = find(name);
  return own >= 0 && stand_in_ ? stand_in_->find({own, name.chart, name.copy}) : own;
}

bool CommittedMesh::NamesAtSeams::is_at_seam(std::int64_t flat) const {
  return flat >= mesh_.mesh_.view().own_cell_count() ||
         mesh_.halo_->is_at_seam(mesh_.stand_in_ ? mesh_.stand_in_->place(flat).own : flat);
}

bool CommittedMesh::NamesAtSeams::is_before(std::int64_t flat, std::int64_t other) const {
  return mesh_.name_in_view(flat) < mesh_.name_in_view(other);
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
  world.agree_after([&] {
    if (!stand_in_ || !stand_in_->set_whole_chart(whole))
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
  std::int64_t any[5];
  const auto compare = [&] {
    const std::int64_t here[] = {is_made() || mesh_.is_adaptive() || on_device_,
                                 !halo_ || halo_topology_ != topology_version_,
                                 halo_geometry_ != geometry_version_,
                                 halo_fields_ != fields_version_, lacks_whole_chart()};
    std::ranges::copy(here, any);
    world.reduce(std::span(any), Reduction::greatest);
  };
  compare();
  if (any[4]) {
    adopt_whole_chart(world, threads, log);
    compare();
  }
  const bool none = any[0], topology = any[1], geometry = any[2], fields = any[3];
  SeamMismatches mismatches;
  try {
    world.agree_after([&] {
      if (none)
        drop_halo();
      else if (!halo_)
        halo_ = std::make_unique<Halo>(*memory_);
    });
    if (!none && topology)
      halo_->find(*this, sides_, world);
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
      if (!none && topology)
        mismatches = find_seam_mismatches(*this);
    });
    if (const std::string what = commit::describe(mismatches, world);
        !what.empty() && world.is_root())
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

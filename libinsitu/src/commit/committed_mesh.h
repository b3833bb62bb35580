#pragma once

#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "accel/faces/face_neighbours.h"
#include "accel/tree/tree.h"
#include "cells/checks/odd_cells.h"
#include "cells/checks/validate.h"
#include "commit/earlier/earlier_mesh.h"
#include "commit/halo/halo.h"
#include "commit/standins/stand_in.h"
#include "commit/tree_fit.h"
#include "commit/tree_policy.h"
#include "core/log.h"
#include "mesh/registered/mesh.h"
#include "query/batch/order.h"
#include "query/locators.h"
#include "query/on_demand.h"
#include "query/sampler.h"
#include "query/seams.h"

namespace insitu::commit {

class AdaptiveCells;

/// A registered mesh with its tree, and the policy that keeps the tree up to date.
class CommittedMesh {
public:
  CommittedMesh(const std::string& name, core::Memory& memory);

  mesh::Mesh& mesh() { return mesh_; }
  const mesh::Mesh& mesh() const { return mesh_; }
  /// The tree, fitted now if that was put off (tree_fit.h); throws as complete() then.
  const accel::Tree& tree() const {
    fit_.complete();
    return tree_;
  }
  /// The same tree as it stands: of this step's cells, in boxes of an earlier one maybe.
  const accel::Tree& standing_tree() const { return tree_; }
  /// automatic: as the policy finds; otherwise how every tree is built from now on.
  void set_builder(accel::Builder builder) { policy_.set_builder(builder); }
  /// How batches of points are located from the next commit on; the tree is kept whatever the
  /// choice, but for a mesh in device memory.
  void set_locator(const query::LocatorChoice& choice) { locators_.choose(choice); }
  const query::Locators& locators() const { return locators_; }
  /// Answers whole batches, or null.
  const query::DeviceLocator* device() const { return locators_.device(); }
  /// An array of the mesh was in device memory at the last commit: only device() answers.
  bool lies_on_device() const { return on_device_; }
  insitu_locator_info locator_info() const; ///< throws INSITU_ERROR_ORDER before the first commit
  /// What device() did. reasons: of its answers, if they are on the host; they are counted.
  void note(const query::DeviceCounts& counts, std::span<const std::uint8_t> reasons = {}) const;
  /// The frame of the mesh's coordinates. Conversions are geo's; a geodetic mesh is located in its
  /// own chart (StandIn), so a change to, from or of that is a change of topology.
  insitu_frame reference_frame = insitu_frame_default();
  /// In longitude and latitude the chart begins at this longitude from the next commit on, unless
  /// cells begin further west.
  double chart_west = ChartFacts::none;
  /// Faces of two processes that do not match to the bit are told if they lie within this of each
  /// other, in the diameter of a face: 0 to SeamMismatches::most_tolerance, of which 0 tells none.
  /// The same on all processes; counts from the next halo on that other cells ask for.
  double seam_tolerance = 1e-6;
  /// Cells of the halo have the values of the fields that this text names, and NaN for others;
  /// null, and on adaptive meshes: of all fields. The same on all processes.
  std::shared_ptr<const std::string> lent_fields_named_in;
  bool lends_field(const std::string& name) const;

  /// Brings the tree up to date with what changed: topology -> validate, rebuild (of a mesh that is
  /// spread over processes once somebody asks the tree, or with its halo); geometry -> refit, or
  /// rebuild when that is due (see TreePolicy), once somebody asks the tree; fields ->
  /// nothing here, or a better tree when that is due. strict refuses converted arrays. Throws
  /// core::Error; the mesh then is not committed.
  insitu_commit_report commit(const core::Threads& threads, const core::Log& log,
                              const core::Memory& memory, bool strict);

  /// Until end_copy() the commits of this mesh, which is new and gets copies of what another one
  /// was given, take that one's tree wherever they find the same cells in the views, with what is
  /// put off of it. `of` is committed, stays as it is and outlives that time.
  void begin_copy(const CommittedMesh& of); // committed_mesh_copy.cpp
  /// From now on the tree is this mesh's, and is kept: no commit finds a better one due.
  void end_copy();

  /// The caller cannot give the arrays: the mesh is not committed, and its commits are to begin
  /// with expect_no_refusal(), which throws INSITU_ERROR_MESH with this message. "": the caller
  /// can.
  void refuse(std::string message) {
    refusal_ = std::move(message);
    committed_ = false;
  }
  void expect_no_refusal() const {
    if (!refusal_.empty())
      throw core::Error(INSITU_ERROR_MESH, "mesh '" + mesh_.name() + "': " + refusal_);
  }

  /// Does now what the commit has put off until a query needs it, and says what it was. Throws
  /// core::Error; the mesh stays committed, and the work is still to be done.
  insitu_commit_report complete(const core::Memory& memory);
  const FitsDone& fits_done() const { return fit_.done(); } ///< what was put off and done since

  /// Validates the arrays as they are; the mesh need not be committed.
  cells::Validation validate(const core::Threads& threads);
  bool committed() const { return committed_ && mesh_.pending() == 0; }
  void require_committed() const; ///< throws INSITU_ERROR_ORDER unless committed
  /// Queries, hinted ones above all, answer fastest once it is known that no cell folds. Topology
  /// commits find out; after the vertices moved, this does, in about three refits' time (once a
  /// step): for callers with many hints. A commit calls it if the step before located many points,
  /// or with a ray method, whose candidates are worth little before.
  void look_for_folds(const core::Threads& threads);
  /// Whether cells are asked one by one whether they fold (query::SoundCells), so that those who
  /// stay in few of them need not look at all.
  bool tells_sound_cells() const { return is_as_any() && sampler().sound_cells(true); }
  /// Finds the cells across faces, if there can be a table of them, for callers that go from cell
  /// to cell. Kept until the topology changes.
  void find_neighbours(const core::Threads& threads);
  /// The same once particles have asked the tree for as many points as finding takes time: then it
  /// costs at most as much again as was lost without. For callers that are about to move some.
  void find_neighbours_if_due(const core::Threads& threads);
  /// The points asked since the topology changed; and back, from a checkpoint on the same cells.
  std::int64_t unguided() const { return locate_counts_.unguided() - unguided_before_; }
  void restore_unguided(std::int64_t points) {
    unguided_before_ = locate_counts_.unguided() - points;
  }
  /// The bytes of the table that this may make; 0 if none.
  std::int64_t neighbours_bytes(const core::Threads& threads) const;
  const accel::FaceNeighbours* neighbours() const { return neighbours_.get(); }
  /// Collective, of a committed mesh: gives it the cells of other processes that touch its own, or
  /// brings them up to date; of an adaptive mesh they are leaves, of which its cells at seams
  /// are made; a mesh in device memory gets none. A mesh in longitude and latitude has the whole
  /// mesh's chart then. Throws parallel::AgreedError; the mesh then is to be committed again.
  void update_halo(parallel::World& world, const core::Threads& threads, const core::Log& log);
  /// From the next update_halo() on, cells that touch over these sides of the mesh's box are in it,
  /// too, and stay in it. All processes say the same.
  void join_sides(const PeriodicAxes& sides);
  /// Collective: whether a mesh that is spread over processes has a halo, or may not be asked
  /// without one, since its cells at seams are made of leaves of several processes (adaptive ones).
  bool needs_halo(parallel::World& world) const;
  /// The chart alone. Collective, of a committed mesh; throws parallel::AgreedError.
  void update_chart(parallel::World& world, const core::Threads& threads, const core::Log& log);
  /// What of others is in the views; null: nothing.
  const Halo* halo() const { return halo_.get(); }
  /// How all processes know a cell of mesh().own_view() of this process, whose rank is known since
  /// the last update_halo().
  CellName name(std::int64_t flat) const;
  /// The same of a cell that points are located in, of mesh().view(), and back. Those that are made
  /// (adaptive meshes' duals) have numbers in the place of global ids, and no pieces.
  CellName located_name(std::int64_t flat) const;
  std::int64_t find_located(const CellName& name) const;
  /// What other processes get of this one's cells is taken from here; and the cell of
  /// mesh().own_view() that such a one is, or is a part of.
  const mesh::MeshView& lent_view() const {
    return lends_parts() ? mesh_.view() : mesh_.own_view();
  }
  std::int64_t own_of_lent(std::int64_t flat) const {
    return lends_parts() ? stand_in_->place(flat).own : flat;
  }
  mesh::FieldView lent_field(const std::string& name) const {
    return lends_parts() ? mesh_.field(name) : mesh_.own_field(name);
  }
  bool lends_parts() const { return stand_in_ && stand_in_->lends_parts(); }
  /// The flat id here of a cell of some process; -1: it is neither this process's nor in the halo.
  std::int64_t find(const CellName& name) const;
  query::Sampler sampler() const {
    return own_sampler().at(halo_ && !(is_made() && mesh_.has_stand_in()) ? &seams_ : nullptr);
  }
  /// The same where of several cells the lowest flat id of this process counts.
  query::Sampler own_sampler() const {
    const query::PointLocator* const own = stand_in_ ? stand_in_->locator() : nullptr;
    return {mesh_.view(),
            tree_,
            &order_,
            &locate_counts_,
            own ? own : &locators_.point_locator(),
            stand_in_ ? stand_in_->chart() : nullptr,
            neighbours_.get(),
            &on_demand_};
  }
  /// Makes the facts that samplers tell those of the whole mesh, where it is spread over processes,
  /// until cells or vertices change here; and whether they are.
  void set_whole_facts(mesh::MeshFacts whole) { on_demand_.facts.set_whole(std::move(whole)); }
  bool knows_whole_facts() const { return on_demand_.facts.is_whole(); }
  /// A location as the solver counts cells, flat over the pieces of mesh().own_view(): the same
  /// unless a stand-in has other cells.
  query::Location own(const query::Location& at, const math::Vec3d& p) const {
    return stand_in_ ? stand_in_->own(at, p) : at;
  }
  /// The same as this process's cells alone tell it, outside where none of them holds the point.
  query::Location own_here(const query::Location& at, const math::Vec3d& p) const {
    if (stand_in_)
      return stand_in_->own_here(at, p);
    return at && at.cell < mesh_.own_view().own_cell_count() ? at : query::Location{};
  }
  /// The mesh's copy audit, and the copies of a stand-in.
  std::vector<insitu_audit_entry> audit() const;
  /// Whether the mesh is flat, on this process or on another, as far as is known; its plane.
  bool is_flat() const { return mesh_.is_flat() || whole_flat_.any(); }
  double plane() const { return mesh_.is_flat() ? mesh_.view().plane : whole_flat_.least; }
  /// Moves points of the mesh's frame into the plane of a flat mesh, where their third coordinate
  /// is of no account.
  void to_plane(std::span<math::Vec3d> points) const {
    for (std::size_t i = 0; is_flat() && i < points.size(); ++i)
      points[i].z = plane();
  }
  /// Of a mesh that was committed and needs one; else null.
  const StandIn* stand_in() const { return stand_in_.get(); }
  insitu_amr_info amr_info() const; ///< throws INSITU_ERROR_ORDER unless adaptive and committed
  /// Of all samplers of this mesh, since it was made.
  const query::LocateCounts& locate_counts() const { return locate_counts_; }
  std::int64_t located() const; ///< points, their sum
  /// So many of these were located for frames: no reason to build the tree anew for values alone.
  void note_drawn(std::int64_t points) const { drawn_ += points; }

  /// Differs from that of every other mesh of the process, past ones too.
  std::uint64_t id() const { return id_; }
  /// Grow with each commit that changed values, or cells and coordinates: for what is made of them.
  std::uint64_t fields_version() const { return fields_version_; }
  std::uint64_t tree_version() const { return tree_version_; }
  std::uint64_t topology_version() const { return topology_version_; }
  /// Grows as topology_version() does, but not where a halo alone has other cells.
  std::uint64_t own_topology_version() const { return own_topology_version_; }
  /// Grows with each commit of what the solver has changed, and neither with halos nor when only
  /// the tree is built anew.
  std::uint64_t own_version() const { return own_version_; }
  /// Grows with each commit of moved vertices or other cells, not when the tree alone is new.
  std::uint64_t geometry_version() const { return geometry_version_; }

  /// The versions that records tell of the solver's cells and of their places: equal ones are the
  /// same. Those of a copy are those that the other mesh had.
  struct Told {
    std::uint64_t topology, geometry;
  };
  Told told_versions() const {
    return told_ ? *told_ : Told{own_topology_version_, geometry_version_};
  }

  /// Keeps copies of this step for pathlines, as mesh::Mesh::keep_earlier() does; of none of the
  /// fields: releases all. with_cells: so that a change of topology leaves the step whole. The
  /// cells are copied at most once a topology; those of an adaptive mesh not before it regrids. An
  /// earlier mesh, which particles have left by now, is released.
  void keep_earlier(const std::vector<mesh::KeptField>& fields, bool with_cells,
                    const core::Threads& threads);
  void release_earlier();
  /// Before keep_earlier(), so that the current step can be done again: keeps what was kept so far
  /// as well; puts it back, in place of what was kept since, if the cells are the same; releases
  /// it.
  void set_earlier_aside();
  void put_earlier_back();
  void release_aside() { aside_.reset(); }
  /// Shows the coordinates that were kept (mesh::Mesh::show_earlier), and hides them. How far
  /// vertices moved is found when the tree is asked.
  bool show_earlier(const core::Threads& threads, bool even_if_still = false);
  void hide_earlier();
  /// The bytes of the cells' copy.
  std::int64_t earlier_cells_bytes(const core::Threads& threads) const;
  /// The step that was kept, if the cells are others since; or null.
  const EarlierMesh* earlier_mesh() const { return earlier_mesh_.get(); }
  /// For a checkpoint, of a step that was kept: the cells of this process on which it is; empty
  /// where a change of topology would not leave it whole, and the cells have no global ids either.
  mesh::CellsCopy copy_earlier_cells(const core::Threads& threads) const;
  /// The same of an adaptive mesh, whose cells the other copy leaves out.
  AdaptiveCells copy_earlier_adaptive() const;
  /// And back, where the cells are others by now: a step from which particles go on to them.
  void set_earlier_mesh(std::unique_ptr<EarlierMesh> mesh) { earlier_mesh_ = std::move(mesh); }
  const std::optional<query::ChartImage>& earlier_chart() const { return kept_.chart; }

private:
  /// Tells cells at seams apart by their names.
  class NamesAtSeams final : public query::Seams {
  public:
    explicit NamesAtSeams(const CommittedMesh& mesh) : mesh_(mesh) {}
    bool is_at_seam(std::int64_t flat) const override;
    bool is_before(std::int64_t flat, std::int64_t other) const override;

  private:
    const CommittedMesh& mesh_;
  };

  /// Brings all up to date with what is pending.
  void commit_pending(insitu_commit_report& report, const core::Threads& threads,
                      const core::Log& log, bool strict);
  void drop_halo();
  void update_leaf_halo(parallel::World& world, const core::Threads& threads);
  bool lacks_whole_chart() const {
    return (stand_in_ && !stand_in_->has_whole_chart()) || lacks_whole_flat();
  }
  bool lacks_whole_flat() const {
    return (mesh_.is_flat() || whole_flat_.any()) && !(mesh_.flat_facts() == agreed_flat_);
  }
  void reduce_flat(parallel::World& world);
  void prepare_flat(bool topology, const core::Log& log);
  void set_flat_turn();
  void adopt_whole_chart(parallel::World& world, const core::Threads& threads,
                         const core::Log& log);
  /// Whatever has changed since.
  void require_a_commit() const;
  std::optional<query::ChartImage> chart() const;
  /// The cells are made from the solver's, and right by construction.
  bool is_made() const { return stand_in_ && stand_in_->is_made(); }
  bool cells_wait() const { return stand_in_ && stand_in_->waits(); }
  /// The cells are the solver's, some of them in copies.
  bool is_copied() const { return stand_in_ && !stand_in_->is_made(); }
  bool tells_one_mesh() const { return stand_in_ && stand_in_->tells_one_mesh(); }
  /// All is found out about the cells that points are located in as about any solver's.
  bool is_as_any() const { return !is_made() && !tells_one_mesh(); }
  void choose_stand_in();
  void part_from_earlier(const core::Threads& threads);
  EarlierMesh::Own own_cells() const;
  void note_queries();
  void forget_neighbours();
  void commit_on_host(std::uint32_t pending, insitu_commit_report& report,
                      const core::Threads& threads, const core::Log& log);
  void commit_on_device(std::uint32_t pending, insitu_commit_report& report,
                        const core::Threads& threads, const core::Log& log);
  void build_tree(insitu_commit_report& report, const core::Threads& threads);
  bool build_may_wait(const core::Threads& threads) const;
  bool fit_may_wait(const core::Threads& threads) const;
  cells::Validation validate_cells(const core::Threads& threads);
  void describe(insitu_commit_report& report) const;
  void tell_overlap(const core::Log& log) const;
  StandIn::Found commit_stand_in(std::uint32_t changed, const core::Threads& threads,
                                 const core::Log& log);
  bool update_tree(bool topology, std::uint32_t& pending, insitu_commit_report& report,
                   const core::Threads& threads);
  void enter_topology(const core::Threads& threads);
  void accept(const cells::Validation& validation, const mesh::MeshView& view,
              const core::Threads& threads, const core::Log& log);
  void update_locators(std::uint32_t pending, const core::Threads& threads);
  void set_odd_cells(cells::OddCells odd, const core::Threads& threads);
  void look_for_overlaps(const core::Threads& threads);
  bool many_were_located() const;
  bool has_cells_of(const CommittedMesh& other) const;
  bool take_tree(const core::Threads& threads);
  void take_chart(const std::unique_ptr<StandIn>& fresh);

  const std::uint64_t id_;
  mesh::Mesh mesh_;
  accel::Tree tree_;
  query::Locators locators_;
  std::unique_ptr<StandIn> stand_in_; ///< of meshes that need one
  std::unique_ptr<accel::FaceNeighbours> neighbours_;
  std::int64_t unguided_before_ = 0;  ///< points, when the topology last changed
  mutable query::SpatialOrder order_; ///< scratch of queries
  mutable query::LocateCounts locate_counts_;
  core::Memory* memory_;
  TreePolicy policy_;
  TreeFit fit_; ///< of tree_
  Displacement displacement_{mesh_};
  query::SoundCells sound_;
  query::LoneCells lone_; ///< of tree_
  query::OnDemand on_demand_;
  std::int64_t located_before_ = 0;            ///< points, when the policy was last told
  mutable std::atomic<std::int64_t> drawn_{0}; ///< points, for frames since then
  std::int64_t located_lately_ = 0; ///< points, between the last two commits that changed something
  std::string refusal_;             ///< by the caller; empty: none
  bool committed_ = false;
  bool on_device_ = false; ///< asked for with every point, so kept
  bool folds_are_known_ = false;
  cells::OddCells odd_cells_;  ///< if so
  std::string overlap_;        ///< of two pieces, when odd cells were last set, as a warning
  bool tree_is_stale_ = false; ///< the mesh was in device memory meanwhile
  int commits_since_build_ = 0;
  std::int64_t rebuilds_seen_ = 0; ///< of those that were put off
  // The halo (committed_mesh_halo.cpp).
  std::unique_ptr<Halo> halo_;
  NamesAtSeams seams_{*this};
  PeriodicAxes sides_{}; ///< over which cells touch
  int rank_ = 0;
  bool in_halo_commit_ = false;
  /// Of a flat mesh of all processes, and of this one's part when that was found.
  mesh::FlatFacts whole_flat_, agreed_flat_;
  /// Of the solver's cells where they are; not known: they moved since they were looked at.
  std::optional<insitu_validation> own_counts_;
  std::uint64_t own_topology_version_ = 0;
  std::uint64_t halo_topology_ = 0, halo_geometry_ = 0, halo_fields_ = 0; ///< versions in it
  std::uint64_t halo_moves_ = 0; ///< since its cells were others
  // The earlier step, for pathlines (committed_mesh_earlier.cpp).
  mesh::CellsCopy earlier_cells_;
  std::uint64_t earlier_cells_version_ = 0; ///< topology_version() of that copy, or of the step
  EarlierMesh::Own earlier_own_;            ///< of it, on several processes
  EarlierMesh::Kept kept_;                  ///< with the step
  std::unique_ptr<EarlierMesh> earlier_mesh_;
  struct Aside {
    mesh::StepsAside steps;
    EarlierMesh::Own own;
    EarlierMesh::Kept kept;
    std::unique_ptr<EarlierMesh> mesh;
    std::uint64_t topology_version;
  };
  std::optional<Aside> aside_;
  std::uint64_t own_version_ = 0, fields_version_ = 0, tree_version_ = 0, topology_version_ = 0,
                geometry_version_ = 0;
  const CommittedMesh* copied_ = nullptr; ///< while this one becomes a copy of it
  std::optional<Told> told_;              ///< of a copy
};

} // namespace insitu::commit

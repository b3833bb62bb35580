#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "accel/tree/tree.h"
#include "cells/checks/odd_cells.h"
#include "commit/standins/stand_in.h"
#include "core/parallel.h"
#include "mesh/box.h"
#include "mesh/registered/cells_copy.h"
#include "mesh/registered/earlier_step.h"
#include "parallel/world.h"
#include "query/chart_image.h"
#include "query/elsewhere.h"
#include "query/on_demand.h"
#include "query/sampler.h"

namespace insitu::commit {

class Adaptive;
class GatheredAdaptive;
class GatheredDual;
struct DualReach;
struct EarlierCells;
enum class CellsKind : std::int64_t;

/// The step before a change of topology, whole: cells, vertices, tree and fields, none of them the
/// solver's. It is there until particles have gone from it to the cells that follow.
class EarlierMesh {
public:
  /// What was known of the step's cells.
  struct Kept {
    bool with_cells = false, covers_once = false;
    bool folds_are_known = false, are_inverted = false; ///< most of them: query::SoundCells
    std::uint64_t tree_version = 0;                     ///< CommittedMesh's then
    cells::OddCells odd;                                ///< a few cells that the tree marks
    std::optional<query::ChartImage> chart; ///< of a geodetic mesh, whose cells are of its images
  };
  /// Of cells of the solver's. tree: of these cells, where their vertices were when it was fitted
  /// last; if told so, it is fitted anew when it is first asked. topology_version: CommittedMesh's
  /// then.
  EarlierMesh(mesh::TakenStep step, mesh::CellsCopy cells, accel::Tree tree, bool refit,
              const Kept& kept, std::uint64_t topology_version, core::Memory& memory,
              const core::Threads& threads);
  /// Of cells that were made (StandIn::is_made), which nothing moves.
  EarlierMesh(mesh::TakenStep step, std::unique_ptr<StandIn> made, accel::Tree tree,
              std::uint64_t topology_version, const core::Threads& threads);
  ~EarlierMesh();
  /// Of several processes: this one's own cells, which are its first, their global ids, if they
  /// have any, and where they are copies on a chart, of which cell and where.
  struct Own {
    std::int64_t cells = 0;
    std::vector<std::int64_t> global; ///< of the solver's cells
    std::vector<StandIn::Place> places;
  };
  void set_own(Own own) { own_ = std::move(own); }
  /// Collective, after a change of topology: the cells of the step of all processes, also of those
  /// that had none, that lie where this one has cells now (their tree) or had some, in the order of
  /// their names, so that of several cells that hold a place the same one counts as in one process.
  /// The sampler's outlook knows where another process had cells beyond them, and hands questions
  /// on to the one given to query::Outlook::ask(); before that, no cell is there. here: this
  /// process's step, or null. chart: on which the tree's cells are, or null. Throws
  /// parallel::AgreedError. Null, on all processes, if none has a step.
  static std::unique_ptr<EarlierMesh> gathered(const EarlierMesh* here, const accel::Tree& now,
                                               const query::ChartImage* chart,
                                               parallel::World& world, core::Memory& memory,
                                               const core::Threads& threads);

  /// Of a checkpoint; its topology_version() is 0. Null if the step was kept without its cells, or
  /// does not fit them.
  static std::unique_ptr<EarlierMesh> restored(const mesh::EarlierStep& step, mesh::CellsCopy cells,
                                               const std::optional<query::ChartImage>& chart,
                                               core::Memory& memory, const core::Threads& threads);
  /// The same of adaptive cells. is_part: other processes may have more, so that these are for
  /// gathered() alone.
  static std::unique_ptr<EarlierMesh> restored(EarlierCells cells, CellsKind kind, bool is_part,
                                               core::Memory& memory, const core::Threads& threads);

  /// Its counts are no mesh's.
  query::Sampler sampler() const {
    return query::Sampler{*view_,   tree_,
                          nullptr,  nullptr,
                          locator_, chart_ ? &*chart_ : nullptr,
                          nullptr,  sound_ ? &on_demand_ : nullptr}
        .with_outlook(beyond_.get());
  }
  /// A field on these cells, if it was kept.
  std::optional<mesh::FieldView> field(const std::string& name) const;
  std::uint64_t topology_version() const { return topology_version_; }

private:
  class Fit final : public query::PutOff {
  public:
    explicit Fit(EarlierMesh& mesh) : mesh_(mesh) {}
    void put_off(int threads) {
      threads_ = threads;
      set_due(true);
    }

  private:
    void do_it() const override;
    EarlierMesh& mesh_;
    int threads_ = 1;
  };

  class Beyond;
  EarlierMesh(EarlierCells& cells, std::unique_ptr<GatheredAdaptive> gathered, core::Memory& memory,
              const core::Threads& threads);
  static std::vector<std::unique_ptr<mesh::EarlierField>>
  fields_of(const mesh::EarlierStep& step, const mesh::MeshView& view, core::Memory& memory);
  static std::unique_ptr<EarlierMesh> of_adaptive(EarlierCells& cells, CellsKind kind,
                                                  std::unique_ptr<GatheredDual> dual, bool is_flat,
                                                  core::Memory& memory,
                                                  const core::Threads& threads);
  CellsKind kind() const;
  DualReach reach() const;
  // Of several processes: gathered_cells.cpp.
  const Adaptive* adaptive() const;
  void know_sound(const core::Threads& threads);
  std::vector<std::int64_t> own_cells_in(std::span<const mesh::Box> boxes) const;
  void tell_values(std::span<const std::int64_t> cells, std::span<const std::int64_t> vertices,
                   mesh::EarlierStep& to) const;
  EarlierCells cells_in(std::span<const mesh::Box> boxes) const;

  mesh::TakenStep step_;
  std::optional<mesh::CellsCopy> cells_; ///< not of cells that were made
  std::unique_ptr<StandIn> made_;
  std::unique_ptr<GatheredAdaptive> gathered_;
  const query::PointLocator* locator_ = nullptr; ///< of either
  std::optional<query::ChartImage> chart_;       ///< of a geodetic mesh
  mesh::MeshView own_view_;
  const mesh::MeshView* view_;
  accel::Tree tree_;
  std::uint64_t topology_version_;
  Fit fit_{*this};
  std::optional<query::SoundCells> sound_; ///< not of cells that were made, here or elsewhere
  query::OnDemand on_demand_;
  Own own_;
  std::unique_ptr<EarlierCells> told_; ///< of a checkpoint: what this process has of the mesh
  CellsKind told_kind_{};
  std::shared_ptr<const query::Outlook> beyond_; ///< of cells that were gathered
};

} // namespace insitu::commit

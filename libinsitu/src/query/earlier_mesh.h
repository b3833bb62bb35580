#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "accel/tree.h"
#include "cells/odd_cells.h"
#include "core/parallel.h"
#include "mesh/cells_copy.h"
#include "mesh/earlier_step.h"
#include "query/adaptive.h"
#include "query/sampler.h"

namespace insitu::query {

/// The step before a change of topology, whole: cells, vertices, tree and fields, none of them the
/// solver's. It is there until particles have gone from it to the cells that follow.
class EarlierMesh {
public:
  /// Of cells of the solver's. tree: of these cells, where their vertices were when it was fitted
  /// last; fitted anew if told so. odd: a few cells that it marks (cells::OddCells).
  /// topology_version: CommittedMesh's then.
  EarlierMesh(mesh::TakenStep step, mesh::CellsCopy cells, accel::Tree tree, bool refit,
              const cells::OddCells& odd, bool covers_once, std::uint64_t topology_version,
              const core::Threads& threads);
  /// Of an adaptive mesh's dual, which nothing moves.
  EarlierMesh(mesh::TakenStep step, std::unique_ptr<Adaptive> adaptive, accel::Tree tree,
              std::uint64_t topology_version);
  /// Of a checkpoint; its topology_version() is 0. Null if the step was kept without its cells, or
  /// does not fit them.
  static std::unique_ptr<EarlierMesh> restored(const mesh::EarlierStep& step, mesh::CellsCopy cells,
                                               core::Memory& memory, const core::Threads& threads);

  /// Its counts are no mesh's.
  Sampler sampler() const { return {*view_, tree_, nullptr, nullptr, nullptr, adaptive_.get()}; }
  /// A field on these cells, if it was kept.
  std::optional<mesh::FieldView> field(const std::string& name) const;
  std::uint64_t topology_version() const { return topology_version_; }

private:
  mesh::TakenStep step_;
  std::optional<mesh::CellsCopy> cells_; ///< not of an adaptive mesh
  std::unique_ptr<Adaptive> adaptive_;
  mesh::MeshView own_view_;
  const mesh::MeshView* view_;
  accel::Tree tree_;
  std::uint64_t topology_version_;
};

} // namespace insitu::query

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "commit/committed_mesh.h"
#include "scene/frames/frame_decisions.h"
#include "scene/frames/frame_settings.h"
#include "scene/run/environment.h"

/// What the processes of a session find out together before they draw a frame. All calls are
/// collective and throw parallel::AgreedError.
namespace insitu::scene {

/// The fields that the frame names of a mesh, as all processes have them.
FieldsByName frame_fields(const FrameLayer& layer, const commit::CommittedMesh& mesh,
                          const Environment& environment);

/// Whether some process draws other cells in the place of the solver's: copies on a chart, or cells
/// that are made of them (adaptive meshes' duals).
struct CellsInPlace {
  bool copies = false, made = false;
};
CellsInPlace find_cells_in_place(const commit::CommittedMesh& mesh, parallel::World& world);

/// Makes the facts that the mesh's samplers tell those of the whole mesh.
void know_whole_facts(commit::CommittedMesh& mesh, const Environment& environment);

/// Makes averages whole at the vertices of other processes' cells, where smooth normals need them.
void complete_averages(const LayerDecisions& decisions, const commit::CommittedMesh& mesh,
                       render::Structures& structures, parallel::World& world);

/// The ranges of all processes' values by which the frame colours and whose pass is decided.
RangesByColor frame_ranges(const LayerDecisions& decisions, render::Structures& structures,
                           parallel::World& world);

/// How the frame tells cells apart: by global ids where all have them, else by numbers that go on
/// from process to process; copies on a chart by numbers behind all these, which ascend with
/// mesh::CellName; cells that are made (adaptive meshes' duals) by their own.
class FrameKeys {
public:
  FrameKeys(const commit::CommittedMesh& mesh, parallel::World& world);
  /// Of a flat cell of this process in the mesh's view.
  std::int64_t key(std::int64_t flat) const;
  /// Of the lowest of the solver's cells of this process that hold a place, where others are drawn;
  /// -1: none.
  std::int64_t solvers_at(const math::Vec3d& place) const;
  /// That of the solver's cell, which may be a copy's.
  std::int64_t solvers(std::int64_t key) const;

private:
  std::int64_t own_key(std::int64_t own) const {
    return by_ids_ ? mesh_->mesh().global_id(INSITU_CELL, own) : before_ + own;
  }

  const commit::CommittedMesh* mesh_;
  bool by_ids_;
  std::int64_t before_ = 0; ///< cells of lower processes
  std::int64_t end_ = 0;    ///< of the keys of cells in their own places
};

/// What processes know of one of the meshes of a frame.
struct LayerOnAll {
  FieldsByName fields;
  CellsInPlace in_place;
  std::optional<FrameKeys> keys;
  RangesByColor ranges;
};

} // namespace insitu::scene

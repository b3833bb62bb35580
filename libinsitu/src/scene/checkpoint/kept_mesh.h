#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "commit/committed_mesh.h"
#include "commit/earlier/adaptive_cells.h"
#include "commit/earlier/earlier_mesh.h"
#include "core/archive.h"
#include "mesh/box.h"
#include "mesh/registered/cells_copy.h"
#include "mesh/registered/earlier_step.h"
#include "parallel/world.h"
#include "query/chart_image.h"
#include "scene/checkpoint/kept_cells.h"

/// What a checkpoint holds of meshes.
namespace insitu::scene {

/// What one process had of a mesh: the step before its next one, and of which cells it is.
struct KeptPart {
  explicit KeptPart(core::Memory& memory) : cells(memory) {}
  /// Of a mesh in host memory, as it is after keep_earlier().
  KeptPart(const commit::CommittedMesh& mesh, core::Memory& memory, const core::Threads& threads);

  std::uint64_t fingerprint = 0;          ///< of its own cells, in their order
  mesh::Box box{};                        ///< of their vertices
  std::uint64_t sum = 0;                  ///< of their ids: commit::sum_of_cells()
  std::int64_t unguided = 0;              ///< commit::CommittedMesh::unguided()
  mesh::EarlierStep step;                 ///< of own cells
  mesh::CellsCopy cells;                  ///< those of the step, or none
  commit::AdaptiveCells adaptive;         ///< those of an adaptive mesh's step
  std::vector<std::int64_t> ids;          ///< the ids of the step's cells, or none
  /// Of copies on a chart: of which of the solver's cells the step's are.
  std::vector<commit::StandIn::Place> places;
  std::optional<query::ChartImage> chart; ///< of a geodetic mesh: where its cells are

  /// Whether the mesh has these cells, by their numbers. is_part: of several processes.
  bool is_of(const commit::CommittedMesh& mesh, bool is_part, const core::Threads& threads) const;
  /// Whether fields were kept, and not the cells that they are on.
  bool lacks_cells() const;
  /// To a checkpoint or back.
  void keep(core::Archive& archive);
};

/// A mesh of a checkpoint, from the restart to the first execution. The parts are dealt to
/// processes: of as many as wrote them each has its own, else each has some or none.
struct KeptMesh {
  struct Part {
    int process; ///< that wrote it
    KeptPart kept;
  };
  std::string name;
  int processes = 1; ///< that wrote it
  std::vector<Part> parts;

  /// Gives the mesh the step before, as far as its cells are known again: those with the numbers
  /// that they had, where as many processes have the same ones; else by their global ids; else on
  /// the checkpoint's cells, from which particles go on to the mesh's. Returns how cells are known,
  /// and tells the log what is lost. Collective; throws parallel::AgreedError.
  KeptCells::By restore(commit::CommittedMesh& mesh, parallel::World& world, core::Memory& memory,
                        const core::Threads& threads, const core::Log& log);

private:
  /// How the charts on which steps were kept go with the one on which the mesh is.
  enum class Charts { others, of_the_same_units, same };
  struct Found;
  Found look_at(const commit::CommittedMesh& mesh, parallel::World& world,
                const core::Threads& threads) const;
  const mesh::EarlierStep* some_step() const;
  Charts look_at_charts(const commit::CommittedMesh& mesh, parallel::World& world) const;
  void restore_by_numbers(commit::CommittedMesh& mesh, bool is_adaptive, parallel::World& world);
  bool restore_by_ids(commit::CommittedMesh& mesh, parallel::World& world);
  void restore_other_cells(commit::CommittedMesh& mesh, bool by_ids, parallel::World& world,
                           core::Memory& memory, const core::Threads& threads);
  std::unique_ptr<commit::EarlierMesh> on_its_cells(bool by_ids, bool is_part, core::Memory& memory,
                                                    const core::Threads& threads);
  commit::EarlierMesh::Own join_parts(bool by_ids);
};

/// A hash of the shapes and vertices of own cells in their order (FNV-1a), of an adaptive mesh of
/// their places: two meshes of the same fingerprint have, but for a chance of 2^-64, the same
/// topology.
std::uint64_t fingerprint(const commit::CommittedMesh& mesh, const core::Threads& threads);

} // namespace insitu::scene

#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "commit/committed_mesh.h"
#include "parallel/world.h"
#include "scene/checkpoint/kept_cells.h"

namespace insitu::scene {

/// Points that go with the material of a moving mesh. Each has its place in a cell on the process
/// that owns it, which moves it; all processes know who that is. Where cells become others, points
/// are located anew on all processes, and may get another owner.
class AttachedPoints {
public:
  AttachedPoints(parallel::World& world, const core::Threads& threads)
      : world_(world), threads_(threads) {}

  /// Takes the points to where the material has carried them; at every cycle, so that they are
  /// known when the cells change. Points that are outside stay where they are, and are looked for
  /// again at the next call. points: the same on all processes at the first call; later a process
  /// knows those that it owns and those that nobody owns. by_ids: all processes have global ids of
  /// cells, of which the lowest owns a point. Collective. Throws parallel::AgreedError.
  void follow(const commit::CommittedMesh& mesh, const query::LocateOptions& options, bool by_ids,
              std::vector<math::Vec3d>& points);

  /// Where a point is in this process's cells, on mesh.view(); nowhere if another process owns it.
  const query::Location& place(std::size_t point) const { return places_[point]; }
  const std::vector<query::Location>& places() const { return places_; }

  /// What a checkpoint has of points, at the root; [point] each.
  struct Kept {
    std::vector<std::int64_t> cells; ///< flat ids there; -1: outside
    std::vector<math::Vec3d> parametric;
    std::vector<mesh::CellName> names; ///< none: of one process
  };
  /// Tells all processes where the points are, and the root what it is to keep. mesh: of the
  /// places; null: there is none. Collective; throws parallel::AgreedError.
  Kept gather(const commit::CommittedMesh* mesh, std::vector<math::Vec3d>& points);
  /// Takes them back, on all processes alike; the next follow() finds their cells.
  void restore(Kept kept) { kept_ = std::move(kept); }
  void take_up_cells(const std::shared_ptr<const KeptCells>& cells) { kept_cells_ = cells; }

private:
  struct Claim;
  struct Moved;
  struct Placed;

  bool bring_home();
  void share(std::vector<math::Vec3d>& points);
  void move(const query::Sampler& sampler, const query::LocateOptions& options,
            std::vector<math::Vec3d>& points, std::vector<Moved>& lost);
  std::vector<Claim> locate(const commit::CommittedMesh& mesh, const query::LocateOptions& options,
                            bool by_ids, std::span<const std::int64_t> some,
                            std::vector<math::Vec3d>& points);
  void settle(std::span<const std::int64_t> some, const std::vector<Claim>& mine);
  void tell_lost(const std::vector<Moved>& lost, std::vector<math::Vec3d>& points);

  parallel::World& world_;
  const core::Threads& threads_;
  std::vector<query::Location> places_; ///< [point]
  std::vector<std::int32_t> owners_;    ///< [point] ranks, -1: nobody; the same on all processes
  std::uint64_t topology_ = 0;
  std::optional<Kept> kept_;                    ///< of a restart, until follow()
  std::shared_ptr<const KeptCells> kept_cells_; ///< null: the mesh was not in the checkpoint
};

} // namespace insitu::scene

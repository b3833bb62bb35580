#pragma once

#include <cstdint>
#include <vector>

#include "commit/committed_mesh.h"
#include "parallel/world.h"

namespace insitu::scene {

/// Which vertices of this process's pieces count in a reduction over the mesh of all processes:
/// those that owning cells use, each place once. Vertices of several pieces or processes are one if
/// they have one global id; without global ids if they coincide to the bit, unless the solver says
/// that its pieces are separate. Of a vertex's copies that of its lowest owning cell counts: by
/// global ids of cells, or by process, piece and cell. A piece that has several vertices at a
/// place, as at a crack, takes no part in that, without global ids.
class CountedVertices {
public:
  /// Brings it up to date with the mesh. Collective, and cheap where no process's cells or vertices
  /// changed. Throws parallel::AgreedError.
  void update(const commit::CommittedMesh& mesh, parallel::World& world,
              const core::Threads& threads);

  bool counts(std::int32_t piece, std::int64_t vertex) const {
    const std::vector<bool>& some = counted_[std::size_t(piece)];
    return some.empty() || some[std::size_t(vertex)];
  }

private:
  class Finder;

  std::vector<std::vector<bool>> counted_; ///< [piece][vertex], or empty: all
  std::uint64_t mesh_ = 0, topology_ = 0, geometry_ = 0;
  bool found_ = false;
};

} // namespace insitu::scene

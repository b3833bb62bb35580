#pragma once

#include <cstdint>
#include <span>
#include <unordered_set>
#include <vector>

#include "advect/field/homes.h"
#include "core/parallel.h"
#include "mesh/box.h"
#include "mesh/view.h"
#include "parallel/world.h"
#include "query/directory.h"
#include "query/elsewhere.h"

/// Particles on several processes: where other processes have cells, and how particles go there.
namespace insitu::advect {

/// Some boxes that hold all cells that this process owns, between the earlier and the current step:
/// at most Directory::most_boxes of them, each of cells whose numbers follow each other.
class OwnBoxes {
public:
  static std::vector<mesh::Box> find(const mesh::MeshView& mesh, const Homes& homes,
                                     const core::Threads& threads);
};

/// What is known in one interval of time of places that no cell here holds.
class OtherCells final : public query::Outlook {
public:
  /// Collective: own are this process's boxes, which all processes get. Errors are agreed on.
  OtherCells(parallel::World& world, std::span<const mesh::Box> own);

  void missed(const math::Vec3d& point, double alpha) const override;
  /// The other processes of whose boxes one holds the point.
  std::vector<int> ranks_at(const math::Vec3d& point) const;
  /// No process has a cell that holds the point. Not while missed() may be called.
  void know_outside(const math::Vec3d& point, double alpha) { outside_.insert({point, alpha}); }

private:
  struct Place {
    math::Vec3d point;
    double alpha;
    bool operator==(const Place& b) const;
  };
  struct Hash {
    std::size_t operator()(const Place& place) const;
  };
  const int rank_;
  query::Directory directory_;
  std::unordered_set<Place, Hash> outside_;
};

} // namespace insitu::advect

#pragma once

#include <cstdint>

#include "accel/tree/tree.h"

namespace insitu::commit {

/// Decides when a mesh's tree is built anew, and how, by what building has cost and what queries
/// have lost: a rebuild is due once the queries have lost as much time to the tree that stands as
/// the better one would cost (so at most about twice the least possible is ever spent). It changes
/// the time, never the answers.
class TreePolicy {
public:
  /// auto lets the policy choose; otherwise every build is of that kind.
  void set_builder(accel::Builder builder) { wanted_ = builder; }

  // What happened, in order.
  void topology_changed();
  /// A build of that kind over so many cells took that long and made a tree of that cost.
  void built(accel::Builder builder, double seconds, std::int64_t cells, double cost);
  /// So many points were located in the tree, whose cost ratio is `cost_ratio`; of_frames: by
  /// frames among them.
  void served(std::int64_t points, std::int64_t of_frames, double cost_ratio);

  // What to do.
  /// How to build, when there is something to build anyway.
  accel::Builder builder() const;
  /// Whether the refitted tree, with that cost ratio, is due to be built anew.
  bool rebuild_is_due(double cost_ratio) const;
  /// Whether the tree in Morton order is due to be replaced by one by surface area, whatever
  /// changed. Points of frames do not count here: what these keep is made for the tree that stands,
  /// and drawing new values of the same cells must not make it anew.
  bool surface_area_is_due() const;

  /// A tree that has come to cost this many times what it cost when it was built is built anew,
  /// however little was asked of it.
  static constexpr double rebuild_ratio = 1.3;

private:
  double surface_area_seconds() const;
  double surface_area_gain() const;

  accel::Builder wanted_ = accel::Builder::automatic;
  accel::Builder stands_ = accel::Builder::automatic;        ///< what the tree was built by
  double morton_seconds_ = 0.0, surface_area_seconds_ = 0.0; ///< of the last builds; 0: never
  double morton_cost_ = 0.0, surface_area_cost_ = 0.0;       ///< of this topology's; 0: never
  double query_seconds_ = 0.0; ///< what the tree's part of a query takes
  double asked_ = 0.0;         ///< seconds that queries spent in this topology's trees
  double drawn_ = 0.0;         ///< those of frames among them
  double lost_ = 0.0;          ///< seconds that they lost to refits since the last build
};

} // namespace insitu::commit

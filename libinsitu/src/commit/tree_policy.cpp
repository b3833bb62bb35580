#include "commit/tree_policy.h"

#include <algorithm>

namespace insitu::commit {

namespace {

using accel::Builder;

/// The tree's part of a random query takes about as long as a build in Morton order does for two
/// cells, on any number of threads (insitu-bench locate beside commit).
constexpr double query_in_cells = 2.0;
/// Until it was measured: what a build by surface area costs in builds in Morton order, and the
/// part of the tree's work that it saves.
constexpr double assumed_price = 5.0, assumed_gain = 0.1;

} // namespace

void TreePolicy::topology_changed() {
  morton_cost_ = surface_area_cost_ = asked_ = drawn_ = lost_ = 0.0;
  stands_ = Builder::automatic;
}

void TreePolicy::built(Builder builder, double seconds, std::int64_t cells, double cost) {
  stands_ = builder;
  lost_ = 0.0;
  if (cells == 0)
    return;
  if (builder == Builder::surface_area) {
    surface_area_seconds_ = seconds;
    surface_area_cost_ = cost;
    return;
  }
  morton_seconds_ = seconds;
  morton_cost_ = cost;
  query_seconds_ = query_in_cells * seconds / double(cells);
}

void TreePolicy::served(std::int64_t points, std::int64_t of_frames, double cost_ratio) {
  const double seconds = double(points) * query_seconds_;
  asked_ += seconds;
  drawn_ += double(of_frames) * query_seconds_;
  lost_ += seconds * std::max(0.0, cost_ratio - 1.0);
}

double TreePolicy::surface_area_seconds() const {
  return surface_area_seconds_ > 0.0 ? surface_area_seconds_ : assumed_price * morton_seconds_;
}

/// What a tree by surface area spares of the work in one in Morton order, by the costs of the last
/// of each over this topology. (Vertices may have moved between the two: an estimate.)
double TreePolicy::surface_area_gain() const {
  if (!(surface_area_cost_ > 0.0 && morton_cost_ > 0.0))
    return assumed_gain;
  return std::max(0.0, 1.0 - surface_area_cost_ / morton_cost_);
}

/// What was asked since the topology changed will be asked again: so it is for meshes that live
/// long, and the others never pay for more than they have had.
Builder TreePolicy::builder() const {
  if (wanted_ != Builder::automatic)
    return wanted_;
  const double price = surface_area_seconds() - morton_seconds_;
  return price > 0.0 && asked_ * surface_area_gain() >= price ? Builder::surface_area
                                                              : Builder::morton;
}

bool TreePolicy::rebuild_is_due(double cost_ratio) const {
  if (cost_ratio > rebuild_ratio)
    return true;
  const double price =
      builder() == Builder::surface_area ? surface_area_seconds() : morton_seconds_;
  return price > 0.0 && lost_ >= price;
}

bool TreePolicy::surface_area_is_due() const {
  return wanted_ == Builder::automatic && stands_ == Builder::morton && morton_seconds_ > 0.0 &&
         (asked_ - drawn_) * surface_area_gain() >= surface_area_seconds();
}

} // namespace insitu::commit

#include "query/gridlet_places.h"

#include <algorithm>

namespace insitu::query {

void GridletPlaces::build(const mesh::GridletsView& gridlets, const amr::LeafMap& leaves) {
  gridlets_ = &gridlets;
  store_ = &leaves.store();
  in_brick_.resize_discard(std::size_t(store_->brick_count()));
  std::fill(in_brick_.begin(), in_brick_.end(), -1);
  bool has_depth[mesh::Lattice::most_depth + 1] = {};
  for (std::int64_t g = 0; g < gridlets.count; ++g) {
    const mesh::Gridlet& gridlet = gridlets.gridlets[g];
    const std::int64_t lower[3] = {gridlet.lower[0], gridlet.lower[1], gridlet.lower[2]};
    in_brick_[store_->find(gridlet.depth, amr::BrickStore::key_of(lower))] = std::int32_t(g);
    has_depth[gridlet.depth] = true;
  }
  depth_count_ = 0;
  for (int d = mesh::Lattice::most_depth; d >= 0; --d) // the finest hold most
    if (has_depth[d])
      depths_[depth_count_++] = std::uint8_t(d);
}

} // namespace insitu::query

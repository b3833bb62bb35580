#include "query/lattice/gridlet_places.h"

#include <algorithm>
#include <cmath>

#include "core/count_bits.h"

namespace insitu::query {

void GridletPlaces::release() {
  gridlets_ = nullptr;
  store_ = nullptr;
  in_brick_.release();
  covers_.release();
  all_full_.release();
}

void GridletPlaces::build(const mesh::GridletsView& gridlets, const amr::LeafMap& leaves,
                          const core::Threads& threads) {
  gridlets_ = &gridlets;
  store_ = &leaves.store();
  in_brick_.resize_discard(std::size_t(store_->brick_count()));
  std::fill(in_brick_.begin(), in_brick_.end(), -1);
  covers_.resize_discard(std::size_t(store_->brick_count()));
  threads.parallel_for(store_->brick_count(), 64, [&](std::int64_t begin, std::int64_t end) {
    using Store = amr::BrickStore;
    for (std::int64_t b = begin; b < end; ++b) {
      const std::uint32_t* const entries = store_->entries(b);
      for (int k = 0; k < Store::side; ++k) {
        Cover& cover = covers_[std::size_t(b)].layer[k] = {0, 0};
        for (int i = 0; i < 64; ++i) {
          const std::uint32_t entry = entries[64 * k + i];
          cover.leaf |= std::uint64_t(Store::is_leaf(entry)) << i;
          cover.finer |= std::uint64_t(!Store::is_leaf(entry) && entry != Store::nothing) << i;
        }
      }
    }
  });
  all_full_.resize_discard(std::size_t((gridlets.count + 63) / 64));
  std::fill(all_full_.begin(), all_full_.end(), 0);
  std::fill(farthest_, farthest_ + 3, 0.0);
  const mesh::Lattice& lattice = gridlets.lattice;
  for (std::int64_t g = 0; g < gridlets.count; ++g) {
    const mesh::Gridlet& gridlet = gridlets.gridlets[g];
    const std::int64_t lower[3] = {gridlet.lower[0], gridlet.lower[1], gridlet.lower[2]};
    in_brick_[store_->find(gridlet.depth, amr::BrickStore::key_of(lower))] = std::int32_t(g);
    std::int64_t full = 0;
    for (int k = 0; k < 8; ++k)
      full += core::count_bits(gridlets.full[8 * g + k]);
    const bool all = full == std::int64_t(gridlet.size[0]) * gridlet.size[1] * gridlet.size[2];
    all_full_[std::size_t(g >> 6)] |= std::uint64_t(all) << (g & 63);
    for (int a = 0; a < 3; ++a)
      for (const double x :
           {gridlets.coordinate(gridlet, a, 0), gridlets.coordinate(gridlet, a, gridlet.size[a])})
        farthest_[a] = std::max(farthest_[a], std::fabs(x) + std::fabs(x - lattice.origin[a]));
  }
  set_steps(lattice);
}

void GridletPlaces::reach_as(const GridletPlaces& other) {
  for (int a = 0; a < 3; ++a)
    farthest_[a] = std::max(farthest_[a], other.farthest_[a]);
  if (gridlets_)
    set_steps(gridlets_->lattice);
}

void GridletPlaces::share_farthest(parallel::World& world) {
  world.reduce(farthest_, parallel::Reduction::greatest);
  if (gridlets_)
    set_steps(gridlets_->lattice);
}

void GridletPlaces::set_steps(const mesh::Lattice& lattice) {
  for (int d = 0; d <= mesh::Lattice::most_depth; ++d)
    for (int a = 0; a < 3; ++a) {
      Steps& steps = steps_[d];
      steps.half_cell[a] = lattice.half_width(a, d);
      steps.a_unit[a] = (1.0 / lattice.spacing[a]) * double(std::int64_t(1) << d);
      steps.rounding[a] = 0x1p-49 * (farthest_[a] * steps.a_unit[a] + 16.0);
    }
}

} // namespace insitu::query

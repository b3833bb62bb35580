#include "query/lattice/culled_cells.h"

#include <algorithm>

#include "query/lattice/gridlet_query.h"

namespace insitu::query {

namespace {

/// Sets `count` bits, is_set(i) each.
template <class IsSet>
void set_bits(core::Buffer<std::uint64_t>& bits, std::int64_t count, const core::Threads& threads,
              IsSet&& is_set) {
  bits.resize_discard(std::size_t((count + 63) / 64));
  threads.parallel_for(std::int64_t(bits.size()), 64, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t word = begin; word < end; ++word) {
      std::uint64_t value = 0;
      const std::int64_t first = word * 64, n = std::min<std::int64_t>(64, count - first);
      for (std::int64_t i = 0; i < n; ++i)
        value |= std::uint64_t(is_set(first + i)) << i;
      bits[std::size_t(word)] = value;
    }
  });
}

} // namespace

bool CulledCells::serves(const Sampler& sampler) {
  return sampler.locator().dual() && sampler.mesh().piece_count == 2 &&
         sampler.tree().odd().empty() && !sampler.tree().empty();
}

std::int64_t CulledCells::primitives_of(const Sampler& sampler) {
  return gridlets_of(sampler.mesh())->count + sampler.mesh().pieces[1].cell_count;
}

void CulledCells::make(const Sampler& sampler, const core::Threads& threads,
                       core::FunctionRef<bool(std::int64_t)> shows) {
  const accel::Tree& whole = sampler.tree();
  const std::int64_t stitching = sampler.mesh().first_cell[1];
  const std::int64_t gridlets = gridlets_of(sampler.mesh())->count;
  primitives_ = whole.cell_count();
  set_bits(shown_, primitives_of(sampler), threads, shows);
  set_bits(slots_, primitives_, threads, [&](std::int64_t slot) {
    const std::int64_t flat = whole.cells()[slot];
    const std::int64_t i =
        flat < stitching ? flat >> mesh::Gridlet::cell_bits : flat - stitching + gridlets;
    return (shown_[std::size_t(i >> 6)] >> (i & 63)) & 1;
  });
  tree_.take_part(whole, slots_.span(), threads);
  DualPlaces places = *sampler.locator().dual();
  places.shown = shown_.data();
  locator_.emplace(places);
}

} // namespace insitu::query

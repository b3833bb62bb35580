#include "advect/across/traveller.h"

#include <string>

#include "core/status.h"

namespace insitu::advect {

OnTheWay OnTheWay::after(const Journey& journey) const {
  OnTheWay way = *this;
  way.stays = false;
  way.stays_here = journey.stays();
  way.is_new_step = journey.is_marked() && (!is_marked || journey.mark().p.time != mark.p.time);
  way.tries = way.is_new_step ? 0 : tries;
  way.is_marked = journey.is_marked();
  if (way.is_marked)
    way.mark = journey.mark();
  return way;
}

void Traveller::name_cells(core::FunctionRef<CellName(std::int64_t)> name_of) {
  cell = name_of(particle.cell);
  std::size_t k = 0;
  if (way.is_marked)
    way.mark.for_each_cell([&](std::int64_t& id) { kept[k++] = name_of(id); });
}

void Traveller::find_cells(const Homes& homes, int rank) {
  const auto find = [&](const CellName& name) {
    const std::int64_t id = name.rank >= 0 ? homes.find(name) : -1;
    if (id < 0 && name.rank == rank)
      throw core::Error(INSITU_ERROR_INTERNAL,
                        "tracer: process " + std::to_string(rank) + " does not find its cell " +
                            std::to_string(name.global) + " (piece " + std::to_string(name.piece) +
                            ", cell " + std::to_string(name.cell) + ")");
    return id;
  };
  particle.cell = find(cell);
  left.cell = has_left ? particle.cell : -1;
  std::size_t k = 0;
  if (way.is_marked)
    way.mark.for_each_cell([&](std::int64_t& id) { id = find(kept[k++]); });
}

} // namespace insitu::advect

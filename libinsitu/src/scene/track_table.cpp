#include "scene/track_table.h"

#include <limits>

namespace insitu::scene {

void TrackTable::write(TrackCycle& cycle) {
  const advect::Particles& p = cycle.particles();
  written_.resize(std::size_t(cycle.seeded()), 0);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (!written_[std::size_t(p.ids[i])] && (cycle.due() || p.endings[i] != INSITU_END_ALIVE))
      indices.push_back(i);
  if (indices.empty() && !cycle.due())
    return;
  const TrackRows& rows = cycle.rows(indices);
  open(rows, cycle.seeded());
  add(rows);
  for (const TrackRow& row : rows.rows)
    written_[std::size_t(row.particle)] = row.ending != INSITU_END_ALIVE;
  if (cycle.due())
    flush();
}

void TrackTable::finish(const advect::Particles& p, std::int64_t cycle, double) {
  if (is_open()) {
    TrackRows rows;
    rows.cycle = cycle;
    rows.pieces = has_pieces();
    rows.columns = value_columns();
    for (std::size_t i = 0; i < p.size(); ++i) {
      const auto id = std::size_t(p.ids[i]);
      if (id >= written_.size() || !written_[id])
        rows.rows.push_back(
            {p.ids[i], p.times[i], p.positions[i], OwnCell{}, insitu_ending(p.endings[i])});
    }
    rows.values.assign(rows.rows.size() * rows.columns.size(),
                       std::numeric_limits<double>::quiet_NaN());
    add(rows);
    try {
      flush();
    } catch (...) {
      close();
      throw;
    }
  }
  close();
}

} // namespace insitu::scene

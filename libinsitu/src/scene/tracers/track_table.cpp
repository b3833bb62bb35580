#include "scene/tracers/track_table.h"

#include <limits>

#include "scene/run/own_cell.h"

namespace insitu::scene {

/// The rows of the last step, and that particles ended in it.
void TrackTable::take_back() {
  for (const std::int64_t id : ended_)
    written_[std::size_t(id)] = 0;
  ended_.clear();
  if (begin_)
    cut_back(*begin_);
  begin_.reset();
}

void TrackTable::write(TrackCycle& cycle) {
  if (note_.again(cycle.step()))
    take_back();
  ended_.clear();
  begin_.reset();
  const advect::Particles& p = cycle.particles();
  written_.resize(std::size_t(cycle.seeded()), 0);
  std::vector<std::size_t> indices;
  for (std::size_t i = 0; i < p.size(); ++i)
    if (!written_[std::size_t(p.ids[i])] &&
        ((cycle.due() && !cycle.has_times()) || p.endings[i] != INSITU_END_ALIVE))
      indices.push_back(i);
  if (indices.empty() && !cycle.due())
    return;
  const TrackRows& rows = cycle.rows(indices);
  open(rows, cycle.seeded());
  frame_ = rows.frame;
  begin_ = end();
  try {
    for (std::size_t k = 0; k < cycle.times().size(); ++k)
      add(cycle.rows_at(k));
    add(rows);
    for (const TrackRow& row : rows.rows)
      if (row.ending != INSITU_END_ALIVE) {
        ended_.push_back(row.particle);
        written_[std::size_t(row.particle)] = 1;
      }
  } catch (...) {
    take_back();
    throw;
  }
  if (cycle.due())
    flush();
}

namespace {

void keep_frame(core::Archive& archive, insitu_frame& frame) {
  archive.value("frame", frame.kind);
  for (double& coordinate : frame.origin)
    archive.value("origin", coordinate);
  archive.value("zone", frame.utm_zone);
  archive.value("north", frame.utm_north);
  archive.value("angle", frame.angle);
  archive.value("length", frame.length);
  archive.value("vertical", frame.vertical);
}

/// Bits of one byte: pieces alone are as they were before there were other names.
void keep_names(core::Archive& archive, CellNames& names) {
  std::uint8_t bits = std::uint8_t(names.pieces | names.global << 1 | names.processes << 2);
  archive.value("pieces", bits);
  names = {(bits & 2) != 0, (bits & 1) != 0, (bits & 4) != 0};
}

} // namespace

void TrackTable::keep(core::Archive& archive) {
  if (!archive.restores() && is_open())
    flush();
  bool is_there = is_open();
  TrackRows none; // what opens the file again
  none.cycle = TrackRows::no_cycle;
  if (is_there) {
    none.columns = value_columns();
    none.names = cell_names();
    none.frame = frame_;
  }
  archive.array("endings written", written_);
  archive.value("table", is_there);
  archive.array("columns", none.columns);
  keep_names(archive, none.names);
  keep_frame(archive, none.frame);
  std::int64_t kept = is_there && !archive.restores() ? size() : 0;
  archive.value("size", kept);
  if (archive.restores() && is_there) {
    open(none, std::int64_t(written_.size()));
    frame_ = none.frame;
    shorten(kept); // to what there was then: a session that closed has killed its particles, too
  }
}

void TrackTable::finish(const advect::Particles& p, const TrackGeodesics& geodesics,
                        std::int64_t cycle, double) {
  if (is_open()) {
    TrackRows rows;
    rows.cycle = cycle;
    rows.names = cell_names();
    rows.columns = value_columns();
    for (std::size_t i = 0; i < p.size(); ++i) {
      const auto id = std::size_t(p.ids[i]);
      if (id >= written_.size() || !written_[id])
        rows.rows.push_back(track_row(p.ids[i], p.times[i], p.positions[i], OwnCell{},
                                      insitu_ending(p.endings[i])));
    }
    rows.values.assign(rows.rows.size() * rows.columns.size(),
                       std::numeric_limits<double>::quiet_NaN());
    const std::size_t width = rows.columns.size(), fields = width - geodesics.columns().size();
    for (std::size_t r = 0; r < rows.rows.size(); ++r)
      geodesics.put(rows.rows[r].particle, rows.values.data() + r * width + fields);
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

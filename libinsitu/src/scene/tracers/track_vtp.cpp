#include <algorithm>
#include <cstdio>
#include <initializer_list>
#include <numeric>

#include "advect/lines/tracks.h"
#include "scene/run/environment.h"
#include "scene/tracers/drawn_lines.h"
#include "scene/tracers/track_writer.h"
#include "scene/tracers/vtp_series.h"

namespace insitu::scene {

namespace {

/// `<name>_<cycle>.vtp`, the particles at each due cycle, or `<name>_t<number>.vtp`, those at each
/// of the tracer's own times, ended ones where they ended, indexed by time in `<name>.pvd`; and
/// `<name>_tracks.vtp`, all tracks so far, with a vertex for each of these moments and one where a
/// particle ended, and the geodesics there: one file, rewritten.
class TrackVtp final : public TrackWriter {
public:
  TrackVtp(const Tracer& tracer, const Environment& environment)
      : name_(tracer.name), environment_(environment), tracks_(environment.context.memory),
        geodesics_(environment.context.memory, INSITU_MEMORY_TRACER),
        own_(tracer.direction == TracerDirection::backward), series_(own_.backward()) {
    for (const TrackGeodesic column : tracer.geodesics)
      columns_.emplace_back(geodesic_name(column));
  }

  bool keeps_ended() const override { return true; }

  void write(TrackCycle& cycle) override {
    if (!cycle.due())
      return;
    if (!note_.again(cycle.step()))
      times_recorded_ = 0;
    for (; times_recorded_ < cycle.times().size(); ++times_recorded_)
      record_time(cycle, times_recorded_);
    record(cycle.particles(), cycle.geodesics(), cycle.has_times()); // those not at the step yet
    if (cycle.has_times()) {
      for (std::size_t k = 0; k < cycle.times().size(); ++k)
        write_time(cycle, k);
    } else {
      std::vector<std::size_t> all(cycle.particles().size());
      std::iota(all.begin(), all.end(), std::size_t(0));
      write_particles({&cycle.rows(all)},
                      cycle_path(environment_, name_, cycle.step().cycle, ".vtp"),
                      cycle.step().time);
    }
    write_tracks(cycle.step().time);
  }

  void finish(const advect::Particles& particles, const TrackGeodesics& geodesics, std::int64_t,
              double time) override {
    record(particles, geodesics);
    write_tracks(time);
  }

  void keep(core::Archive& archive) override {
    tracks_.keep(archive);
    if (!columns_.empty())
      archive.array("track geodesics", geodesics_);
  }

private:
  void record(const advect::Particles& particles, const TrackGeodesics& geodesics,
              bool ended_alone = false) {
    const std::size_t width = columns_.size(), first = tracks_.record(particles, ended_alone);
    geodesics_.resize(tracks_.size() * width);
    for (std::size_t v = first; v < tracks_.size(); ++v)
      geodesics.put(tracks_.particles()[v], geodesics_.data() + v * width);
  }

  /// The vertices of the particles that are there at the time.
  void record_time(const TrackCycle& cycle, std::size_t k) {
    const advect::Particles& p = cycle.particles();
    const advect::Snapshots& at = cycle.snapshots();
    for (std::size_t i = 0; i < p.size(); ++i)
      if (const std::size_t item = at.item(k, i); at.present[item]) {
        tracks_.record(p.ids[i], cycle.times()[k].time, at.positions[item], at.places[item].cell);
        geodesics_.resize(tracks_.size() * columns_.size());
        if (!columns_.empty())
          cycle.geodesics().put_snapshot(item, geodesics_.end() - columns_.size());
      }
  }

  /// Those that are there at the time, and those that had ended before.
  void write_time(TrackCycle& cycle, std::size_t k) {
    const advect::Particles& p = cycle.particles();
    const advect::Snapshots& at = cycle.snapshots();
    const DueTime& due = cycle.times()[k];
    std::vector<std::size_t> ended;
    for (std::size_t i = 0; i < p.size(); ++i)
      if (!at.present[at.item(k, i)] && p.endings[i] != INSITU_END_ALIVE &&
          !own_.is_before(due.time, p.times[i]))
        ended.push_back(i);
    char digits[32];
    std::snprintf(digits, sizeof digits, "%06lld", static_cast<long long>(due.number));
    write_particles({&cycle.rows_at(k), &cycle.rows(ended)},
                    environment_.output + "/" + name_ + "_t" + digits + ".vtp", due.time);
  }

  void write_particles(std::initializer_list<const TrackRows*> parts, const std::string& path,
                       double time) {
    std::vector<math::Vec3d> points;
    std::vector<std::int64_t> ids, cells;
    std::vector<std::int32_t> pieces, processes;
    const CellNames& names = (*parts.begin())->names;
    std::vector<std::uint8_t> endings;
    std::vector<double> values;
    for (const TrackRows* part : parts) {
      for (const TrackRow& row : part->rows) {
        points.push_back(row.position);
        ids.push_back(row.particle);
        cells.push_back(names.cell(row.cell));
        pieces.push_back(row.cell.piece);
        processes.push_back(row.cell.process);
        endings.push_back(std::uint8_t(row.ending));
      }
      values.insert(values.end(), part->values.begin(), part->values.end());
    }
    const TrackRows& from = **parts.begin();
    const VtkColumns columns(from.columns, values);
    output::VtkPolyData data;
    data.points = vtk_points(points);
    data.point_data.push_back(output::vtk_array("particle", std::span<const std::int64_t>(ids)));
    data.point_data.push_back(output::vtk_array("cell", std::span<const std::int64_t>(cells)));
    if (names.pieces)
      data.point_data.push_back(output::vtk_array("piece", std::span<const std::int32_t>(pieces)));
    if (names.processes)
      data.point_data.push_back(
          output::vtk_array("process", std::span<const std::int32_t>(processes)));
    data.point_data.push_back(output::vtk_array("ending", std::span<const std::uint8_t>(endings)));
    columns.add_to(data.point_data);
    series_.write(environment_, name_, path, time, data);
  }

  void write_tracks(double time) {
    core::Buffer<std::int64_t> order(environment_.context.memory, INSITU_MEMORY_TRACER);
    const advect::Polylines lines = tracks_.lines(&order);
    const std::size_t width = columns_.size();
    std::vector<double> ordered(order.size() * width);
    for (std::size_t v = 0; v < order.size(); ++v)
      std::copy_n(geodesics_.data() + std::size_t(order[v]) * width, width,
                  ordered.data() + v * width);
    const VtkColumns columns(columns_, ordered);
    const DrawnLines drawn(lines);
    output::VtkPolyData data;
    data.points = vtk_points(lines.points.span());
    data.point_data.push_back(output::vtk_array("time", lines.times.span()));
    columns.add_to(data.point_data);
    drawn.add_to(data, "particle");
    data.has_time = true;
    data.time = time;
    output::write_vtp(environment_.output + "/" + name_ + "_tracks.vtp", data);
    ++environment_.statistics.files;
  }

  std::string name_;
  Environment environment_;
  advect::Tracks tracks_;
  std::vector<std::string> columns_; ///< of the geodesics
  core::Buffer<double> geodesics_;   ///< [vertex of tracks_][column]
  OwnTime own_;                      ///< the tracer's
  VtpSeries series_;
  StepNote note_;
  std::size_t times_recorded_ = 0; ///< in tracks_, of the step's
};

} // namespace

std::unique_ptr<TrackWriter> make_track_vtp(const Tracer& tracer, const Environment& environment) {
  return std::make_unique<TrackVtp>(tracer, environment);
}

} // namespace insitu::scene

#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "advect/lines/snapshots.h"
#include "core/archive.h"
#include "scene/parse/description.h"
#include "scene/run/environment.h"
#include "scene/run/output_times.h"
#include "scene/run/own_cell.h"
#include "scene/run/step.h"
#include "scene/tracers/track_geodesics.h"

/// How the particles of path- and streaklines are written: the tracer moves them, and hands each of
/// its writers, one a format, what there is at a cycle.
namespace insitu::scene {

/// A particle as a file has it.
struct TrackRow {
  std::int64_t particle; ///< its id
  double time;
  math::Vec3d position; ///< in the mesh's coordinates
  OwnCell cell;         ///< as the solver counts cells
  insitu_ending ending;
};
/// Zeros without their signs, as all files have times and places.
TrackRow track_row(std::int64_t particle, double time, const math::Vec3d& position, OwnCell cell,
                   insitu_ending ending);

/// Some particles at a cycle, with what is recorded along the tracks.
struct TrackRows {
  /// Of a restart, whose files are opened as they are: they are cut by size then.
  static constexpr std::int64_t no_cycle = std::numeric_limits<std::int64_t>::max();
  std::int64_t cycle = 0;
  std::vector<TrackRow> rows;
  CellNames names;                             ///< of the rows' cells
  insitu_frame frame = insitu_frame_default(); ///< of the mesh
  std::vector<std::string> columns;            ///< of the values: fields, then geodesics
  std::vector<double> values;                  ///< [row][column], NaN outside
};

/// A cycle of a tracer, as its writers see it. A tracer with times of its own is due in a cycle
/// that reaches some of them, and its particles are then written as they were at those; if they
/// ended, as they are.
class TrackCycle {
public:
  virtual ~TrackCycle() = default;
  virtual const Step& step() const = 0;
  virtual bool due() const = 0;
  virtual const advect::Particles& particles() const = 0;
  virtual std::int64_t seeded() const = 0;
  virtual const TrackGeodesics& geodesics() const = 0;
  /// The tracer has times of its own; those reached in this cycle, and the particles at them.
  virtual bool has_times() const = 0;
  virtual std::span<const DueTime> times() const = 0;
  virtual const advect::Snapshots& snapshots() const = 0;
  /// Of the particles that are there at times()[k]. Valid until the next call.
  virtual const TrackRows& rows_at(std::size_t k) = 0;
  /// Of the particles with these indices (not ids). Valid until the next call.
  virtual const TrackRows& rows(const std::vector<std::size_t>& indices) = 0;
};

/// Writes one format. Throws core::Error (INSITU_ERROR_FILE, or INSITU_ERROR_FIELD where fields
/// changed so that they no longer fit the file); what was not written then is written by the next
/// call, if the particles are still there.
class TrackWriter {
public:
  virtual ~TrackWriter() = default;
  /// Called at every cycle, after the particles have moved.
  virtual void write(TrackCycle& cycle) = 0;
  /// The session closes, the particles have been killed, and there is no field any more. cycle: the
  /// last one that the tracer executed.
  virtual void finish(const advect::Particles& particles, const TrackGeodesics& geodesics,
                      std::int64_t cycle, double time) = 0;
  /// Its state, to a checkpoint or back; what waits for the file is written first. When it comes
  /// back, the file is cut to what it was then.
  virtual void keep(core::Archive& archive) = 0;
  /// Whether it asks for particles after the cycle in which they ended.
  virtual bool keeps_ended() const { return false; }
};

/// The writer of a tracer's format.
std::unique_ptr<TrackWriter> make_track_writer(TableFormat format, const Tracer& tracer,
                                               const Environment& environment);

// Of the formats.
std::unique_ptr<TrackWriter> make_track_csv(const Tracer& tracer, const Environment&);
std::unique_ptr<TrackWriter> make_track_netcdf(const Tracer& tracer, const Environment&);
std::unique_ptr<TrackWriter> make_track_vtp(const Tracer& tracer, const Environment&);

} // namespace insitu::scene

#pragma once

#include <cstdint>

#include "advect/lines/polylines.h"
#include "advect/particles.h"
#include "core/memory.h"

namespace insitu::advect {

/// Where particles were, whenever the caller asked to remember it.
class Tracks {
public:
  explicit Tracks(core::Memory& memory);

  /// Appends a vertex for every particle whose time is another than at its last one: those alive,
  /// and once those that have ended since. Seeds not found inside (yet) have none. Call it before
  /// drop_ended(). Returns the index of the first new vertex. ended_alone: not of those alive.
  std::size_t record(const Particles& particles, bool ended_alone = false);
  /// Appends a vertex of one particle, alive at that time.
  void record(std::int64_t particle, double time, const math::Vec3d& point, std::int64_t cell);

  /// Everything, to a checkpoint or back.
  void keep(core::Archive& archive);

  std::size_t size() const { return particles_.size(); }
  const core::Buffer<math::Vec3d>& points() const { return points_; }
  const core::Buffer<double>& times() const { return times_; }
  const core::Buffer<std::int64_t>& cells() const { return cells_; }
  const core::Buffer<std::int64_t>& particles() const { return particles_; }

  /// The vertices as one line a particle, in the order of ids, each in the order of recording.
  /// order, if not null, becomes the index here of each of the lines' vertices: what the caller
  /// keeps per vertex is put in order by it. Particles without a vertex have no line.
  Polylines lines(core::Buffer<std::int64_t>* order = nullptr) const;

private:
  void know(std::size_t ids);

  core::Memory* memory_;
  core::Buffer<math::Vec3d> points_;
  core::Buffer<double> times_;
  core::Buffer<std::int64_t> cells_;
  core::Buffer<std::int64_t> particles_;
  core::Buffer<double> last_time_;     ///< [id] of the last vertex, NaN: none
  core::Buffer<std::uint8_t> endings_; ///< [id] as last seen
};

} // namespace insitu::advect

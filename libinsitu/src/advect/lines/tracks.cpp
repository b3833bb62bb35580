#include "advect/lines/tracks.h"

#include <algorithm>
#include <limits>

namespace insitu::advect {

Tracks::Tracks(core::Memory& memory)
    : memory_(&memory), points_(memory, INSITU_MEMORY_TRACER), times_(memory, INSITU_MEMORY_TRACER),
      cells_(memory, INSITU_MEMORY_TRACER), particles_(memory, INSITU_MEMORY_TRACER),
      last_time_(memory, INSITU_MEMORY_TRACER), endings_(memory, INSITU_MEMORY_TRACER) {}

/// Makes room for so many particles.
void Tracks::know(std::size_t ids) {
  const std::size_t known = last_time_.size();
  if (ids <= known)
    return;
  last_time_.resize(ids);
  endings_.resize(ids);
  std::fill(last_time_.begin() + known, last_time_.end(), std::numeric_limits<double>::quiet_NaN());
  std::fill(endings_.begin() + known, endings_.end(), std::uint8_t(INSITU_END_ALIVE));
}

void Tracks::record(std::int64_t particle, double time, const math::Vec3d& point,
                    std::int64_t cell) {
  know(std::size_t(particle) + 1);
  last_time_[std::size_t(particle)] = time;
  points_.push_back(point);
  times_.push_back(time);
  cells_.push_back(cell);
  particles_.push_back(particle);
}

std::size_t Tracks::record(const Particles& particles, bool ended_alone) {
  const std::size_t first_new = size();
  if (particles.size() == 0)
    return first_new;
  // Ids count up, so the last particle has the largest.
  know(std::size_t(particles.ids[particles.size() - 1]) + 1);

  for (std::size_t i = 0; i < particles.size(); ++i) {
    const std::size_t id = std::size_t(particles.ids[i]);
    endings_[id] = particles.endings[i];
    if (particles.fresh[i] || last_time_[id] == particles.times[i] ||
        (ended_alone && particles.endings[i] == INSITU_END_ALIVE))
      continue;
    last_time_[id] = particles.times[i];
    points_.push_back(particles.positions[i]);
    times_.push_back(particles.times[i]);
    cells_.push_back(particles.cells[i]);
    particles_.push_back(particles.ids[i]);
  }
  return first_new;
}

void Tracks::keep(core::Archive& archive) {
  archive.array("track points", points_);
  archive.array("track times", times_);
  archive.array("track cells", cells_);
  archive.array("track particles", particles_);
  archive.array("last times", last_time_);
  archive.array("last endings", endings_);
}

Polylines Tracks::lines(core::Buffer<std::int64_t>* order) const {
  // A counting sort by id, which keeps the order of recording.
  core::Buffer<std::int64_t> next(*memory_, INSITU_MEMORY_TRACER);
  next.resize_discard(last_time_.size() + 1);
  std::fill(next.begin(), next.end(), 0);
  for (const std::int64_t id : particles_)
    ++next[std::size_t(id) + 1];

  Polylines lines(*memory_);
  lines.offsets.push_back(0);
  for (std::size_t id = 0; id < last_time_.size(); ++id) {
    if (next[id + 1] > 0) {
      lines.particles.push_back(std::int64_t(id));
      lines.endings.push_back(endings_[id]);
      lines.offsets.push_back(next[id] + next[id + 1]);
    }
    next[id + 1] += next[id];
  }

  lines.points.resize_discard(size());
  lines.times.resize_discard(size());
  lines.cells.resize_discard(size());
  if (order)
    order->resize_discard(size());
  for (std::size_t v = 0; v < size(); ++v) {
    const std::size_t to = std::size_t(next[std::size_t(particles_[v])]++);
    lines.points[to] = points_[v];
    lines.times[to] = times_[v];
    lines.cells[to] = cells_[v];
    if (order)
      (*order)[to] = std::int64_t(v);
  }
  return lines;
}

} // namespace insitu::advect

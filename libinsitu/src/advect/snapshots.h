#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "advect/dense.h"
#include "advect/particles.h"
#include "advect/settings.h"
#include "core/memory.h"
#include "query/sampler.h"

namespace insitu::advect {

/// Where all particles are at times within an advance, by the dense output of the steps that they
/// take in any case. Of the particle with index i at times[k], item(k, i) tells.
class Snapshots {
public:
  /// times: ascending.
  Snapshots(std::vector<double> at, core::Memory& memory)
      : times(std::move(at)), positions(memory, INSITU_MEMORY_TRACER),
        places(memory, INSITU_MEMORY_TRACER), present(memory, INSITU_MEMORY_TRACER) {}

  /// Room for so many particles, none of them present.
  void begin(std::size_t particle_count) {
    particles = particle_count;
    const std::size_t items = times.size() * particles;
    positions.resize_discard(items);
    places.resize_discard(items);
    present.resize_discard(items);
    std::fill(present.begin(), present.end(), std::uint8_t(0));
  }
  std::size_t item(std::size_t k, std::size_t i) const { return k * particles + i; }

  std::vector<double> times;
  std::size_t particles = 0;
  core::Buffer<math::Vec3d> positions;  ///< in the mesh's coordinates
  core::Buffer<query::Location> places; ///< none where a path cuts a corner of the mesh
  core::Buffer<std::uint8_t> present;   ///< 0: the particle had not begun, or has ended, by then
};

/// Fills in one particle's snapshots, as a visitor of integrate() and by what else moves it. A
/// particle has snapshots after its own time, a fresh one at it, too.
template <class Field>
class SnapshotTaker {
public:
  SnapshotTaker(Snapshots& all, std::size_t particle, const State& p, Field& field,
                const query::Sampler& sampler, insitu_accuracy accuracy)
      : all_(all), particle_(particle), field_(field), sampler_(sampler), accuracy_(accuracy),
        last_(p.x), last_time_(p.time) {
    const auto& times = all.times;
    next_ = std::size_t((p.fresh ? std::lower_bound(times.begin(), times.end(), p.time)
                                 : std::upper_bound(times.begin(), times.end(), p.time)) -
                        times.begin());
    first_ = next_;
  }

  void operator()(const State& p) {
    take(p, [&](double) { return p.x; });
  }
  void operator()(const State& p, const DenseStep& path) {
    take(p, [&](double t) { return t == p.time ? p.x : path.at_time(t); });
  }

  /// It went straight to p since the last call, as to a boundary.
  void straight(const State& p) {
    along(p, [&](const Vec3d& from, double part) { return from + part * (p.x - from); });
  }
  /// The same by the place path(from, part) after a part of the time.
  template <class Path>
  void along(const State& p, Path&& path) {
    const Vec3d from = last_;
    const double begin = last_time_;
    take(p,
         [&](double t) { return t == p.time ? p.x : path(from, (t - begin) / (p.time - begin)); });
  }
  /// It was set there.
  void set(const State& p) { (*this)(p); }

  /// It was displaced at its time: so it is there at that time.
  void displaced(const State& p) {
    std::size_t first = next_;
    while (first > 0 && all_.times[first - 1] == p.time && first > first_)
      --first;
    next_ = first;
    set(p);
  }

  /// What it did after this was undone.
  void back_to(const State& before) {
    while (next_ > first_ && all_.times[next_ - 1] > before.time)
      all_.present[all_.item(--next_, particle_)] = 0;
    last_ = before.x;
    last_time_ = before.time;
  }

  /// It ended at its time: its end tells of that.
  void ended(const State& p) {
    while (next_ > first_ && !(all_.times[next_ - 1] < p.time))
      all_.present[all_.item(--next_, particle_)] = 0;
  }

private:
  template <class At>
  void take(const State& p, At&& at) {
    for (; next_ < all_.times.size() && all_.times[next_] <= p.time; ++next_) {
      const double t = all_.times[next_];
      const std::size_t item = all_.item(next_, particle_);
      const Vec3d x = field_.position(at(t));
      all_.positions[item] = x;
      all_.places[item] = sampler_.locate(x, field_.cell(), {accuracy_, field_.geometry_alpha(t)});
      all_.present[item] = 1;
    }
    last_ = p.x;
    last_time_ = p.time;
  }

  Snapshots& all_;
  std::size_t particle_;
  Field& field_;
  const query::Sampler& sampler_;
  insitu_accuracy accuracy_;
  std::size_t first_ = 0, next_ = 0; ///< of the times
  Vec3d last_;                       ///< the end of the last step, as integrate() has it
  double last_time_;
};

} // namespace insitu::advect

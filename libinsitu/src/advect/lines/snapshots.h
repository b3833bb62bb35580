#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "advect/effects/sides.h"
#include "advect/integrate/dense.h"
#include "advect/integrate/settings.h"
#include "advect/lines/recorder.h"
#include "advect/particles.h"
#include "core/memory.h"
#include "query/sampler.h"
#include "query/walk/beside_mesh.h"

namespace insitu::advect {

/// Where all particles are at times within an advance, by the dense output of the steps that they
/// take in any case. Of the particle with index i at times[k], item(k, i) tells.
class Snapshots {
public:
  /// times: in the order in which the particles come to them.
  Snapshots(std::vector<double> at, core::Memory& memory)
      : times(std::move(at)), positions(memory, INSITU_MEMORY_TRACER),
        places(memory, INSITU_MEMORY_TRACER), present(memory, INSITU_MEMORY_TRACER) {}

  /// Room for so many particles, none of them present. backward: their times descend.
  void begin(std::size_t particle_count, bool backward = false) {
    particles = particle_count;
    backward_ = backward;
    const std::size_t items = times.size() * particles;
    positions.resize_discard(items);
    places.resize_discard(items);
    present.resize_discard(items);
    std::fill(present.begin(), present.end(), std::uint8_t(0));
    hops.assign(particles, 0);
  }
  /// Room for more particles, those behind the others.
  void grow(std::size_t particle_count);
  std::size_t item(std::size_t k, std::size_t i) const { return k * particles + i; }
  bool is_before(double a, double b) const { return backward_ ? b < a : a < b; }

  std::vector<double> times;
  std::size_t particles = 0;
  core::Buffer<math::Vec3d> positions;  ///< in the mesh's coordinates
  core::Buffer<query::Location> places; ///< none where a path cuts a corner of the mesh
  core::Buffer<std::uint8_t> present;   ///< 0: the particle had not begun, or has ended, by then
  /// How often a particle had changed process in the interval when it came to be here.
  std::vector<std::int32_t> hops;

private:
  bool backward_ = false;
};

/// Fills in one particle's snapshots. A particle has snapshots after its own time, a fresh one at
/// it, too.
template <class Field>
class SnapshotTaker final : public Recorder {
public:
  /// p.x: as the field has it, in whose coordinates p begins. The arguments must outlive the
  /// object; sides: of which a mover makes use.
  SnapshotTaker(Snapshots& all, std::size_t particle, const State& p, Field& field,
                const query::Sampler& sampler, insitu_accuracy accuracy, const Sides& sides)
      : all_(all), particle_(particle), field_(field), sampler_(sampler), accuracy_(accuracy),
        sides_(sides), last_(point_of(p.x)), last_time_(p.time) {
    const auto& times = all.times;
    const auto before = [&](double a, double b) { return all.is_before(a, b); };
    next_ = std::size_t((p.fresh ? std::lower_bound(times.begin(), times.end(), p.time, before)
                                 : std::upper_bound(times.begin(), times.end(), p.time, before)) -
                        times.begin());
    first_ = next_;
  }

  void operator()(const State& p) override {
    take(p, [&](double) { return field_.position(p.x); });
  }
  void operator()(const State& p, const DenseStep& path) override {
    take(p, [&](double t) { return field_.position(t == p.time ? p.x : path.at_time(t)); });
  }
  void flew(const State& p, const Flight& path) override {
    take(p,
         [&](double t) { return t == p.time ? field_.position(p.x) : in_frame(path.at_time(t)); });
  }
  void straight(const State& p) override { bent(p, {}); }
  void bent(const State& p, const Vec3d& bend) override {
    const Way way(space(), sides_, last_, point_of(p.x));
    const double begin = last_time_;
    take(p, [&](double t) {
      return t == p.time ? field_.position(p.x)
                         : in_frame(way.at((t - begin) / (p.time - begin), bend));
    });
  }
  void displaced(const State& p) override {
    std::size_t first = next_;
    while (first > 0 && all_.times[first - 1] == p.time && first > first_)
      --first;
    next_ = first;
    (*this)(p);
  }
  void back_to(const State& before, const Vec3d& point) override {
    while (next_ > first_ && all_.is_before(before.time, all_.times[next_ - 1]))
      all_.present[all_.item(--next_, particle_)] = 0;
    last_ = point;
    last_time_ = before.time;
  }

  RecorderMark mark() const override { return {first_, next_, last_, last_time_}; }
  /// Goes on from a mark of this or, in another process, of the same particle's; what was taken
  /// here since is taken back.
  void go_on_from(const RecorderMark& mark) {
    while (next_ > mark.next)
      all_.present[all_.item(--next_, particle_)] = 0;
    first_ = mark.first;
    next_ = mark.next;
    last_ = mark.last;
    last_time_ = mark.last_time;
  }

  /// It ended at its time: its end tells of that.
  void ended(const State& p) {
    while (next_ > first_ && !all_.is_before(all_.times[next_ - 1], p.time))
      all_.present[all_.item(--next_, particle_)] = 0;
  }

private:
  static constexpr bool has_points = requires(const Field& f, Vec3d& x) { f.point(x, x); };

  Space space() const {
    if constexpr (has_points)
      return field_.space();
    return Space(nullptr);
  }
  /// The point among the cells that the integrator's position is.
  Vec3d point_of(const Vec3d& x) const {
    Vec3d point = x;
    if constexpr (has_points)
      field_.point(x, point);
    return point;
  }
  Vec3d in_frame(const Vec3d& point) const {
    if constexpr (has_points)
      return field_.in_frame(point);
    return point;
  }

  /// at(t): the position in the mesh's frame.
  template <class At>
  void take(const State& p, At&& at) {
    for (; next_ < all_.times.size() && !all_.is_before(p.time, all_.times[next_]); ++next_) {
      const double t = all_.times[next_];
      const std::size_t item = all_.item(next_, particle_);
      Vec3d x = at(t);
      const query::LocateOptions options{accuracy_, field_.geometry_alpha(t)};
      query::Location place = sampler_.locate(x, field_.cell(), options);
      if (!place) // between steps along a wall, rounding may be beyond it
        place = query::bring_inside(
            sampler_, x, query::rounding_in(sampler_.mesh(), field_.cell(), options.alpha),
            options);
      all_.positions[item] = x;
      all_.places[item] = place;
      all_.present[item] = 1;
    }
    last_ = point_of(p.x);
    last_time_ = p.time;
  }

  Snapshots& all_;
  std::size_t particle_;
  Field& field_;
  const query::Sampler& sampler_;
  insitu_accuracy accuracy_;
  const Sides& sides_;
  std::size_t first_ = 0, next_ = 0; ///< of the times
  Vec3d last_;                       ///< where it was last, among the cells
  double last_time_;
};

} // namespace insitu::advect

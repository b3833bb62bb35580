#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "advect/integrate/even_spacing.h"
#include "advect/integrate/integrate.h"
#include "advect/lines/streamlines.h"
#include "query/sampler.h"

namespace insitu::advect {

struct LineVertex {
  math::Vec3d point;
  double time;
  std::int64_t cell;
};

/// Keeps vertices of a line: those of its steps, at least `spacing` cells apart, or points at even
/// distances.
template <class Velocity>
class LineVertices {
public:
  LineVertices(Velocity& velocity, const query::Sampler& sampler,
               const StreamlineSettings& settings, std::vector<LineVertex>& vertices)
      : velocity_(velocity), sampler_(sampler), settings_(settings), vertices_(vertices),
        even_(velocity, settings.even_time, settings.even_length, *this) {
    vertices.clear();
  }
  LineVertices(const LineVertices&) = delete;

  bool is_even() const { return settings_.even_time > 0.0 || settings_.even_length > 0.0; }
  EvenSpacing<Velocity, LineVertices>& even() { return even_; }

  /// As visitor of integrate().
  void operator()(const State& s) {
    if (vertices_.empty() || cells_crossed(s.x - last_, velocity_.extent()) >= settings_.spacing)
      add(s);
  }
  /// A point at an even distance, or another that the line shall have.
  void operator()(const math::Vec3d& point, double time) {
    const query::Location at = sampler_.locate(point, velocity_.cell(), {settings_.accuracy});
    vertices_.push_back({point, time, at.cell});
  }

  /// The last vertex is the line's end, p, whatever the spacing.
  insitu_ending finish(const State& p, insitu_ending ending) {
    if (!is_even()) {
      if (!vertices_.empty() && p.x != last_)
        add(p);
    } else if (vertices_.size() > 1 && even_.since_last(p) < 1e-3) {
      vertices_.back() = {velocity_.position(p.x), p.time, velocity_.cell()};
    } else if (!vertices_.empty() && p.time != vertices_.back().time) {
      add(p);
    }
    return ending == INSITU_END_ALIVE ? INSITU_END_EXPIRED : ending;
  }

private:
  void add(const State& s) {
    vertices_.push_back({velocity_.position(s.x), s.time, velocity_.cell()});
    last_ = s.x;
  }

  Velocity& velocity_;
  const query::Sampler& sampler_;
  const StreamlineSettings& settings_;
  std::vector<LineVertex>& vertices_;
  EvenSpacing<Velocity, LineVertices> even_;
  math::Vec3d last_; ///< as the integrator has it; after a change of its coordinates it is far away
};

} // namespace insitu::advect

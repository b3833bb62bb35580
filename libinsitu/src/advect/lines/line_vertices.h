#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

#include "advect/field/journey.h"
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
class LineVertices : public Marked {
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

  RecorderMark mark() const override {
    const auto even = even_.keep();
    return {count(), std::uint64_t(even.count), last_, last_time_, even.begin, even.travelled, {}};
  }
  /// Goes on from a mark of the same line, whose vertices so far are elsewhere but for those that
  /// this object has of them; what came here since is taken back.
  void go_on_from(const RecorderMark& mark) {
    if (vertices_.empty())
      first_ = mark.first;
    vertices_.resize(std::size_t(mark.first - first_));
    last_ = mark.last;
    last_time_ = mark.last_time;
    even_.go_on_from({mark.begin, mark.travelled, std::int64_t(mark.next)});
  }
  /// The number on the line of the first vertex here.
  std::uint64_t first() const { return first_; }
  /// The vertices of the line so far, wherever they are, and the time of the last.
  std::uint64_t count() const { return first_ + vertices_.size(); }
  double last_time() const { return last_time_; }
  /// The last vertex becomes this one.
  void replace_last(const LineVertex& by) {
    if (vertices_.empty())
      --first_; // in the place of one that is elsewhere
    else
      vertices_.pop_back();
    vertices_.push_back(by);
    last_time_ = by.time;
  }

  /// As visitor of integrate().
  void operator()(const State& s) {
    if (count() == 0 || cells_crossed(s.x - last_, velocity_.extent()) >= settings_.spacing)
      add(s);
  }
  /// A point at an even distance, or another that the line shall have.
  void operator()(const math::Vec3d& point, double time) {
    const query::Location at = sampler_.locate(point, velocity_.cell(), {settings_.accuracy});
    vertices_.push_back({point, time, at.cell});
    last_time_ = time;
  }

  /// The last vertex is the line's end, p, whatever the spacing.
  insitu_ending finish(const State& p, insitu_ending ending) {
    if (!is_even()) {
      if (count() > 0 && p.x != last_)
        add(p);
    } else if (count() > 1 && even_.since_last(p) < 1e-3) {
      replace_last({velocity_.position(p.x), p.time, velocity_.cell()});
    } else if (count() > 0 && p.time != last_time_) {
      add(p);
    }
    return ending == INSITU_END_ALIVE ? INSITU_END_EXPIRED : ending;
  }

private:
  void add(const State& s) {
    vertices_.push_back({velocity_.position(s.x), s.time, velocity_.cell()});
    last_ = s.x;
    last_time_ = s.time;
  }

  Velocity& velocity_;
  const query::Sampler& sampler_;
  const StreamlineSettings& settings_;
  std::vector<LineVertex>& vertices_;
  EvenSpacing<Velocity, LineVertices> even_;
  math::Vec3d last_; ///< as the integrator has it; after a change of its coordinates it is far away
  double last_time_ = 0.0;
  std::uint64_t first_ = 0;
};

} // namespace insitu::advect

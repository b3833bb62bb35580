#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "advect/effects/sides.h"
#include "advect/lines/line_vertices.h"
#include "advect/lines/recorder.h"

namespace insitu::advect {

/// The line of a particle that a Mover moves: its vertices, and where it ends as removed. At a
/// periodic side it has two vertices of one time, on that side and on the opposite one.
template <class V>
class LineRecorder final : public Recorder {
public:
  /// The arguments must outlive the object.
  LineRecorder(V& velocity, const query::Sampler& sampler, const StreamlineSettings& settings,
               const Sides& sides, std::vector<LineVertex>& vertices)
      : velocity_(velocity), sampler_(sampler), settings_(settings), sides_(sides),
        vertices_(vertices), put_(velocity, sampler, settings, vertices) {}

  RecorderMark mark() const override {
    RecorderMark mark = put_.mark();
    mark.moved = {last_, last_time_, last_length_, evens_from_, bends_, bend_};
    return mark;
  }
  /// See LineVertices.
  void go_on_from(const RecorderMark& mark) {
    put_.go_on_from(mark);
    last_ = mark.moved.at;
    last_time_ = mark.moved.time;
    last_length_ = mark.moved.length;
    evens_from_ = mark.moved.evens_from;
    bends_ = mark.moved.bends;
    bend_ = mark.moved.bend;
    is_over_ = false;
  }
  std::uint64_t first() const { return put_.first(); }

  void operator()(const State& p) override {
    if (put_.count() == 0) {
      put_.is_even() ? put_.even()(p) : put_(p);
      is_over_ = removes(velocity_.position(p.x), p.time);
    }
    note(p);
  }
  void operator()(const State& p, const DenseStep& path) override {
    follow(
        path.start(), path.step(), p,
        [&](double part) { return velocity_.position(part == 1.0 ? p.x : path.at(part)); },
        [&](double part) { return EvenSpacing<V, LineVertices<V>>::speed(velocity_, path, part); });
  }
  void flew(const State& p, const Flight& path) override {
    follow(
        path.start(), path.step(), p,
        [&](double part) {
          return part == 1.0 ? velocity_.position(p.x) : velocity_.in_frame(path.at(part));
        },
        [&](double part) { return path.step() * path.speed(part); });
  }
  void straight(const State& p) override {
    if (put_.count() == 0)
      return; // seeded outside
    bend();
    const Vec3d to = point_of(p.x);
    Way way(velocity_.space(), sides_, last_, to);
    double begin = last_time_, length = p.length - last_length_;
    Vec3d before, after;
    for (int axis = 0; axis < 3 && way.passes_side(); ++axis) {
      const double part = way.side(before, after), at = begin + part * (p.time - begin);
      follow_way(way, part, begin, at, part * length);
      if (is_over_)
        return;
      if (put_.last_time() == at)
        put_.replace_last(located(velocity_.in_frame(before), at));
      else
        vertex(velocity_.in_frame(before), at);
      vertex(velocity_.in_frame(after), at);
      length -= part * length;
      begin = at;
      way = Way(velocity_.space(), sides_, after, to);
    }
    follow_way(way, 1.0, begin, p.time, length);
    bends_ = !is_over_ && !put_.is_even() && p.time != put_.last_time();
    bend_ = velocity_.position(p.x);
    note(p);
  }
  void displaced(const State& p) override { note(p); }
  void back_to(const State&, const Vec3d&) override {} // no effect on lines does

  bool is_over() const override { return is_over_; }

  /// The last vertex is the line's end, p, in this cell.
  insitu_ending finish(const State& p, std::int64_t cell, insitu_ending ending) {
    if (is_over_)
      return INSITU_END_REMOVED;
    if (put_.count() == 0)
      return ending;
    const LineVertex end{velocity_.position(p.x), p.time, cell};
    const bool near = put_.is_even() && put_.count() > std::max<std::uint64_t>(1, evens_from_) &&
                      put_.even().since_last(p) < 1e-3;
    if (near || put_.last_time() == p.time)
      put_.replace_last(end);
    else
      vertices_.push_back(end);
    return ending == INSITU_END_ALIVE ? INSITU_END_EXPIRED : ending;
  }

private:
  /// A step to p, or to where the line ends within it: where its condition begins to hold, by
  /// halving.
  template <class Position, class Speed>
  void follow(double start, double step, const State& p, Position&& position, Speed&& speed) {
    bend();
    const double whole = part_left(start, step, p.time, position);
    if (put_.is_even())
      put_.even().follow(
          start, whole * step, whole == 1.0 ? p.time : start + whole * step,
          [&](double part) { return position(whole * part); },
          [&](double part) { return whole * speed(whole * part); });
    else if (!is_over_)
      put_(p);
    if (is_over_)
      vertex(position(whole), start + whole * step);
    note(p);
  }
  /// A part of a straight way.
  void follow_way(const Way& way, double part, double start, double end, double length) {
    const auto position = [&](double theta) { return velocity_.in_frame(way.at(theta * part)); };
    const double whole = part_left(start, end - start, end, position), step = whole * (end - start);
    if (put_.is_even() && end != start)
      put_.even().follow(
          start, step, whole == 1.0 ? end : start + step,
          [&](double theta) { return position(whole * theta); },
          [&](double) { return whole * length; });
    if (is_over_)
      vertex(position(whole), start + step);
  }

  /// 1, or the part of a step after which the line is removed.
  template <class Position>
  double part_left(double start, double step, double end, Position&& position) {
    if (!settings_.effects.removes || !removes(position(1.0), end))
      return 1.0;
    is_over_ = true;
    double low = 0.0, high = 1.0;
    for (int i = 0; i < 48; ++i) {
      const double middle = 0.5 * (low + high);
      (removes(position(middle), start + middle * step) ? high : low) = middle;
    }
    return high;
  }
  bool removes(const Vec3d& x, double time) const {
    if (!settings_.effects.removes)
      return false;
    const query::Location at = sampler_.locate(x, velocity_.cell(), {settings_.accuracy});
    return at && settings_.effects.is_removed(sampler_, at, x, std::abs(time));
  }

  /// A line that goes on from where it went straight to has a vertex there.
  void bend() {
    if (bends_)
      vertex(bend_, last_time_);
    bends_ = false;
  }
  void vertex(const Vec3d& x, double time) {
    put_(x, time);
    evens_from_ = put_.count();
  }
  LineVertex located(const Vec3d& x, double time) const {
    return {x, time, sampler_.locate(x, velocity_.cell(), {settings_.accuracy}).cell};
  }
  Vec3d point_of(const Vec3d& x) const {
    Vec3d point = x;
    velocity_.point(x, point);
    return point;
  }
  void note(const State& p) {
    last_ = point_of(p.x);
    last_time_ = p.time;
    last_length_ = p.length;
  }

  V& velocity_;
  const query::Sampler& sampler_;
  const StreamlineSettings& settings_;
  const Sides& sides_;
  std::vector<LineVertex>& vertices_;
  LineVertices<V> put_;
  std::uint64_t evens_from_ = 0; ///< the vertices from here on are at even distances
  bool is_over_ = false;
  Vec3d last_; ///< where it was last, among the cells
  double last_time_ = 0.0, last_length_ = 0.0;
  bool bends_ = false; ///< at bend_, if it goes on
  Vec3d bend_;
};

} // namespace insitu::advect

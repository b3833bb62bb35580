#pragma once

#include <cmath>
#include <cstdint>

#include "advect/integrate/dense.h"
#include "advect/integrate/integrators.h"
#include "advect/integrate/settings.h"

namespace insitu::advect {

/// The points of a path that lie at even distances from its start, in time or along the curve, by
/// the dense output of its steps. put(x, t) receives each, in order, from the start on; at most
/// `most` of them.
template <class Field, class Put>
class EvenSpacing {
public:
  static constexpr std::int64_t most = 1'000'000;

  /// One of the distances is above 0: of time, or of length in the field's measure. put(x, t): x in
  /// the mesh's frame.
  EvenSpacing(const Field& field, double time, double length, Put& put)
      : field_(field), time_(time), length_(length), put_(put) {}

  /// How far it has come, and a spacing that goes on from there.
  struct Kept {
    double begin, travelled;
    std::int64_t count;
  };
  Kept keep() const { return {begin_, travelled_, count_}; }
  void go_on_from(const Kept& kept) {
    begin_ = kept.begin;
    travelled_ = kept.travelled;
    count_ = kept.count;
  }

  /// As visitor of integrate().
  void operator()(const State& p) { // the start
    begin_ = p.time;
    put_(field_.position(p.x), p.time);
    count_ = 1;
  }
  void operator()(const State& p, const DenseStep& path) {
    follow(
        path.start(), path.step(), p.time,
        [&](double theta) { return field_.position(theta == 1.0 ? p.x : path.at(theta)); },
        [&](double theta) { return speed(field_, path, theta); });
  }

  /// dlength / dtheta. A field may measure displacements halfway along them, so by a short one.
  static double speed(const Field& field, const DenseStep& path, double theta) {
    constexpr double part = 0x1p-20;
    return measure(field, path.at(theta), part * path.rate(theta)) / part;
  }

  /// Any step from the time `start` to `end`, which is start + step to rounding: after a part theta
  /// of it, position(theta) in the mesh's frame, with speed(theta) = dlength / dtheta.
  template <class Position, class Speed>
  void follow(double start, double step, double end, Position&& position, Speed&& speed) {
    if (time_ > 0.0) {
      const double direction = step < 0.0 ? -1.0 : 1.0;
      for (; count_ < most; ++count_) { // by multiplication, so that no error adds up
        const double t = begin_ + direction * double(count_) * time_;
        if (!(direction * (end - t) >= 0.0))
          return;
        put_(position(t == end ? 1.0 : (t - start) / step), t);
      }
    } else {
      const double whole = length_to(speed, 1.0);
      for (; count_ < most && double(count_) * length_ <= travelled_ + whole; ++count_) {
        const double theta = theta_at(speed, double(count_) * length_ - travelled_, whole);
        put_(position(theta), start + theta * step);
      }
      travelled_ += whole;
    }
  }

  /// How far p, the end of the last step, is beyond the last point, as a part of the distance.
  double since_last(const State& p) const {
    return time_ > 0.0 ? std::abs(p.time - begin_) / time_ - double(count_ - 1)
                       : travelled_ / length_ - double(count_ - 1);
  }

private:
  /// The length of the curve from 0 to theta: Gauss's formula of 5 points on each half (Abramowitz
  /// and Stegun, table 25.4).
  template <class Speed>
  double length_to(Speed&& speed, double theta) const {
    constexpr double node[] = {0.0, 0.538469310105683091, 0.906179845938663993};
    constexpr double weight[] = {0.568888888888888889, 0.478628670499366468, 0.236926885056189088};
    const double half = 0.25 * theta;
    double sum = 0.0;
    for (const double middle : {half, 3.0 * half}) {
      sum += weight[0] * speed(middle);
      for (int i = 1; i < 3; ++i)
        sum += weight[i] * (speed(middle - node[i] * half) + speed(middle + node[i] * half));
    }
    return half * sum;
  }

  /// Where the curve is so long: Newton's method within a bracket.
  template <class Speed>
  double theta_at(Speed&& speed, double length, double whole) const {
    double low = 0.0, high = 1.0, theta = whole > 0.0 ? length / whole : 0.0;
    for (int i = 0; i < 50; ++i) {
      const double off = length_to(speed, theta) - length;
      if (std::abs(off) <= 1e-12 * length_)
        break;
      (off < 0.0 ? low : high) = theta;
      const double next = theta - off / speed(theta);
      theta = next > low && next < high ? next : 0.5 * (low + high);
    }
    return theta;
  }

  const Field& field_;
  double time_, length_;
  Put& put_;
  double begin_ = 0.0, travelled_ = 0.0;
  std::int64_t count_ = 0;
};

} // namespace insitu::advect

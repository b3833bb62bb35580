#pragma once

#include <algorithm>
#include <optional>
#include <type_traits>
#include <vector>

#include "advect/effects/drift.h"
#include "advect/field/chart_velocity.h"

namespace insitu::advect {

/// The step before the current one, on cells of its own: after a change of topology.
struct StepBefore {
  query::Sampler sampler;
  mesh::FieldView velocity;
  std::vector<Drift> drifts; ///< the effects', with the fields of that step
};

/// What is inside between two steps on different cells.
enum class Between : std::uint8_t {
  either, ///< what either step's mesh holds; its velocity serves alone where the other does not
  current ///< what the current one's holds: for walls and other displacements, which are its own
};

/// The velocity between two steps on different cells, drifts included: at time t, with alpha = (t -
/// t0) / (t1 - t0), (1 - alpha) of what the step before has at the place and alpha of what the
/// current one has, each located in its own cells and its own geometry. Where one of them does not
/// hold the place, the other one's serves alone. Faces of either are kinks, so steps do not end at
/// them. V: DriftVelocity or, of geodetic meshes, ChartVelocity, where this stands; there each mesh
/// has its own images of a place, and positions are in the current one's coordinates. One object
/// serves one thread.
template <class V>
class CrossingVelocity {
  static constexpr bool is_chart = std::is_same_v<V, ChartVelocity>;

public:
  /// As V's; before must outlive the object as well.
  CrossingVelocity(const query::Sampler& sampler, const mesh::FieldView& velocity,
                   const StepBefore& before, double t0, double t1, insitu_accuracy accuracy,
                   std::span<const Drift> drifts, Between between)
      : now_(sampler, velocity, nullptr, t0, t1, accuracy, drifts),
        then_(before.sampler, before.velocity, nullptr, t0, t1, accuracy, before.drifts),
        between_(between) {}

  void walk_by(const CellsBeyond* beyond) { now_.walk_by(beyond); }
  // On several processes the current cells are those between which the particle travels.
  void travel_by(Journey* journey) { now_.travel_by(journey); }
  Journey* journey() const { return now_.journey(); }
  KeptVelocity keep() const { return now_.keep(); }
  void enter_as(const KeptVelocity& kept) {
    now_.enter_as(kept);
    then_.go_by(now_);
  }
  math::Vec3d position_as(const KeptVelocity& kept, const math::Vec3d& x) const {
    return now_.position_as(kept, x);
  }
  void go_on_from(const KeptVelocity& kept) {
    now_.go_on_from(kept);
    then_.go_by(now_);
    const WayMark& mark = journey()->mark();
    in_now_ = mark.cell != -1;
    then_.begin(-1); // what it held follows from the place
    math::Vec3d u;
    in_then_ = then_(mark.p.x, mark.p.time, u) != Sampled::outside;
    if (in_then_)
      then_.accepted();
  }
  /// hint: of the current cells, or -1; only the time it takes depends on it.
  void begin(std::int64_t hint) {
    now_.begin(hint);
    then_.begin(-1);
    in_now_ = in_then_ = false;
  }
  math::Vec3d enter(const math::Vec3d& position) {
    const math::Vec3d x = now_.enter(position);
    then_.go_by(now_);
    return x;
  }
  math::Vec3d position(const math::Vec3d& x) const { return now_.position(x); }
  void go_by(const CrossingVelocity& other) {
    now_.go_by(other.now_);
    then_.go_by(now_);
  }

  Sampled operator()(const math::Vec3d& x, double t, math::Vec3d& v) {
    math::Vec3d u;
    const Sampled now = now_(x, t, v);
    return between(t, now, then_(x, t, u), u, v);
  }
  /// At a point among the current cells; `at`: among them, or none.
  Sampled sample(const math::Vec3d& x, double t, math::Vec3d& v, query::Location& at) {
    const Sampled now = now_.sample(x, t, v, at);
    const Space here = now_.space(), before = then_.space();
    const math::Vec3d y = before.image_of(here, x);
    math::Vec3d u;
    const Sampled then = then_.sample(y, t, u, there_);
    turned_ = !before.has_axes_of(here, x, y);
    return between(t, now, then, before.in_axes_of(here, x, y, u), v);
  }

  void accepted() {
    in_now_ = asked_now_;
    in_then_ = asked_then_;
    if (in_now_)
      now_.accepted();
    if (in_then_)
      then_.accepted();
  }
  /// The same of the mesh that holds the position, the current one first.
  math::Vec3d kept_inside(const math::Vec3d& x) {
    return in_now_ ? now_.kept_inside(x) : in_then_ ? then_.kept_inside(x) : x;
  }
  math::Vec3d kept_inside(const math::Vec3d& x, double) { return kept_inside(x); }
  math::Vec3d kept_at(const math::Vec3d& point) { return in_now_ ? now_.kept_at(point) : point; }
  /// Of the particle's position among the current cells, or -1.
  std::int64_t cell() const { return in_now_ ? now_.cell() : -1; }

  /// Between two steps of integrate(), and what is long: of ChartVelocity.
  void settle(math::Vec3d& x, math::Vec3d& rate) requires is_chart {
    now_.settle(x, rate);
    then_.go_by(now_);
  }
  double length(const math::Vec3d& x, const math::Vec3d& d) const requires is_chart {
    return now_.length(x, d);
  }

  /// See ExitingField. Within rounding of it, neither mesh holds more.
  std::optional<query::Exit> leave(const math::Vec3d& a, const math::Vec3d& b, double t,
                                   double dt) {
    return in_now_ ? now_.leave(a, b, t, dt) : then_.leave(a, b, t, dt);
  }

  /// Of the smaller of the cells that hold the position, along each axis.
  math::Vec3d extent() {
    if (!in_then_)
      return now_.extent();
    math::Vec3d extent = then_.extent();
    if (in_now_) {
      const math::Vec3d other = now_.extent();
      for (int a = 0; a < 3; ++a)
        extent[a] = std::min(extent[a], other[a]);
    }
    return extent;
  }
  double geometry_alpha(double t) const { return now_.geometry_alpha(t); }
  int velocity_steps() const { return 2; }
  bool blends_geometry() const { return false; }

  // Points among the cells.
  Space space() const { return now_.space(); }
  bool point(const math::Vec3d& x, math::Vec3d& point) const { return now_.point(x, point); }
  math::Vec3d place(const math::Vec3d& point) {
    const math::Vec3d x = now_.place(point);
    then_.go_by(now_);
    return x;
  }
  math::Vec3d in_frame(const math::Vec3d& point) const { return now_.in_frame(point); }
  bool comes_back(const math::Vec3d& point, std::int64_t cell, double alpha) requires is_chart {
    const bool comes = now_.comes_back(point, cell, alpha);
    then_.go_by(now_);
    return comes;
  }
  const MeshVelocity& flow() const { return now_.flow(); }
  // At the point sampled last.
  math::Vec3d rate_of_change(const query::Location&, double) const {
    const double interval = flow().interval();
    return interval != 0.0 ? change_ / interval : math::Vec3d{};
  }
  /// Where the cells before are on a chart turned otherwise, of the current ones alone.
  math::Vec3d gradient(const query::Location& at, int component, double t) const {
    const math::Vec3d now = now_.gradient(at, component, t);
    if (!asked_then_ || turned_)
      return now;
    const double part = flow().alpha(t);
    return (1.0 - part) * then_.gradient(there_, component, t) + part * now;
  }

private:
  /// Of what the current mesh has, v, and the one before, u.
  Sampled between(double t, Sampled now, Sampled then, const math::Vec3d& u, math::Vec3d& v) {
    const double part = now_.flow().alpha(t);
    asked_now_ = now != Sampled::outside;
    asked_then_ = then != Sampled::outside;
    if (!asked_now_ && (!asked_then_ || between_ == Between::current))
      return Sampled::outside;
    if (now == Sampled::not_finite || then == Sampled::not_finite)
      return Sampled::not_finite;
    change_ = {};
    if (!asked_now_) {
      v = u;
    } else if (asked_then_) {
      change_ = v - u;
      v = (1.0 - part) * u + part * v;
    }
    return Sampled::inside;
  }

  V now_, then_;
  Between between_;
  bool asked_now_ = false, asked_then_ = false; ///< the meshes that hold the point asked last
  bool in_now_ = false, in_then_ = false;       ///< and the particle's position
  bool turned_ = false;                         ///< the axes before, where a point was sampled last
  query::Location there_;                       ///< that point, in the cells before
  math::Vec3d change_;                          ///< of the velocity there over the interval
};

} // namespace insitu::advect

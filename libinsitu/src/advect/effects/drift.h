#pragma once

#include <cmath>
#include <span>

#include "advect/effects/effects.h"
#include "advect/effects/space.h"
#include "advect/field/mesh_velocity.h"
#include "geo/upright.h"

namespace insitu::advect {

/// What a drift adds at a place and time; times: of the steps.
inline math::Vec3d velocity_of(const Drift& drift, const query::Sampler& sampler,
                               const query::Location& at, const StepTimes& times, double t) {
  if (!drift.field)
    return drift.constant;
  double u[3] = {0.0, 0.0, 0.0};
  drift.field->value(sampler, at, times, t, u);
  if (drift.field->now.components == 1)
    return (drift.factor * u[0]) * drift.direction;
  return drift.factor * math::Vec3d{u[0], u[1], sampler.mesh().is_flat ? 0.0 : u[2]};
}

/// The velocity on a mesh with what drifts add to it. Integrators see the sum, so its error is
/// controlled like any flow's. For a Mover, which moves particles also by displacements: between
/// points among the cells (see Space), which are the integrator's positions here.
class DriftVelocity {
public:
  /// As MeshVelocity's; drifts must outlive the object as well.
  DriftVelocity(const query::Sampler& sampler, const mesh::FieldView& now,
                const EarlierSteps& earlier, double t0, double t1, insitu_accuracy accuracy,
                std::span<const Drift> drifts)
      : flow_(sampler, now, earlier, t0, t1, accuracy), drifts_(drifts) {}

  void walk_by(const CellsBeyond* beyond) { flow_.walk_by(beyond); }
  void begin(std::int64_t hint) { flow_.begin(hint); }
  math::Vec3d enter(const math::Vec3d& position) const { return position; }
  math::Vec3d position(const math::Vec3d& x) const { return x; }
  void enter_as(const KeptVelocity&) const {}
  math::Vec3d position_as(const KeptVelocity&, const math::Vec3d& x) const { return x; }
  void go_by(const DriftVelocity&) const {}
  void travel_by(Journey* journey) { flow_.travel_by(journey); }
  Journey* journey() const { return flow_.journey(); }
  KeptVelocity keep() const { return flow_.keep(); }
  void go_on_from(const KeptVelocity& kept) { flow_.go_on_from(kept); }

  Sampled operator()(const math::Vec3d& x, double t, math::Vec3d& v) {
    query::Location at;
    return sample(x, t, v, at);
  }
  /// At a point among the cells, in lengths along the axes there; `at` is where it lies.
  Sampled sample(const math::Vec3d& x, double t, math::Vec3d& v, query::Location& at) {
    if (const Sampled s = flow_.sample(x, t, v, at); s != Sampled::inside)
      return s;
    for (const Drift& drift : drifts_) {
      const math::Vec3d u = velocity_of(drift, flow_.sampler(), at, flow_.times(), t);
      v += drift.is_local ? geo::from_east_north_up(geo::upright(x).normal, u) : u;
    }
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) ? Sampled::inside
                                                                          : Sampled::not_finite;
  }

  void accepted() { flow_.accepted(); }
  math::Vec3d kept_inside(const math::Vec3d& x) { return flow_.kept_inside(x); }
  math::Vec3d kept_inside(const math::Vec3d& x, double t) { return flow_.kept_inside(x, t); }
  /// The same of a point among the cells.
  math::Vec3d kept_at(const math::Vec3d& point) { return flow_.kept_inside(point); }
  std::int64_t cell() const { return flow_.cell(); }

  // See CellwiseField and ExitingField.
  bool confine(const math::Vec3d& x, const math::Vec3d& towards, double t) {
    return flow_.confine(x, towards, t);
  }
  void release() { flow_.release(); }
  double depth(const math::Vec3d& x, double t) { return flow_.depth(x, t); }
  double last_depth() const { return flow_.last_depth(); }
  double face_on(const DenseStep& path, double low, double high) {
    return flow_.face_on(path, low, high);
  }
  bool is_inside_before(const DenseStep& path) const { return flow_.is_inside_before(path); }
  Crossed cross(const math::Vec3d& x, const math::Vec3d& towards, double t) {
    return flow_.cross(x, towards, t);
  }
  std::optional<query::Exit> leave(const math::Vec3d& a, const math::Vec3d& b, double t,
                                   double dt) {
    return flow_.leave(a, b, t, dt);
  }
  double way_out(const math::Vec3d& a, const math::Vec3d& b, double t) {
    return flow_.way_out(a, b, t);
  }

  math::Vec3d extent() { return flow_.extent(); }
  double geometry_alpha(double t) const { return flow_.geometry_alpha(t); }
  int velocity_steps() const { return flow_.velocity_steps(); }
  bool blends_geometry() const { return flow_.blends_geometry(); }

  // Points among the cells.
  Space space() const { return Space(nullptr); }
  bool point(const math::Vec3d& x, math::Vec3d& point) const {
    point = x;
    return true;
  }
  math::Vec3d place(const math::Vec3d& point) const { return point; }
  math::Vec3d in_frame(const math::Vec3d& point) const { return point; }
  const MeshVelocity& flow() const { return flow_; }
  // Of the flow alone, at the point sampled last, which lies at `at`.
  math::Vec3d rate_of_change(const query::Location& at, double t) const {
    return flow_.rate_of_change(at, t);
  }
  math::Vec3d gradient(const query::Location& at, int component, double t) const {
    return flow_.gradient(at, component, t);
  }

private:
  MeshVelocity flow_;
  std::span<const Drift> drifts_;
};

} // namespace insitu::advect

#pragma once

#include <cmath>
#include <span>

#include "advect/effects.h"
#include "advect/mesh_velocity.h"

namespace insitu::advect {

/// What a drift adds at a place and time; times: of the steps.
inline math::Vec3d velocity_of(const Drift& drift, const query::Sampler& sampler,
                               const query::Location& at, const StepTimes& times, double t) {
  if (!drift.field)
    return drift.constant;
  double u[3];
  drift.field->value(sampler, at, times, t, u);
  if (drift.field->now.components == 1)
    return (drift.factor * u[0]) * drift.direction;
  return drift.factor * math::Vec3d{u[0], u[1], u[2]};
}

/// The velocity on a mesh with what drifts add to it. Integrators see the sum, so its error is
/// controlled like any flow's.
class DriftVelocity {
public:
  /// The arguments must outlive the object.
  DriftVelocity(MeshVelocity& flow, std::span<const Drift> drifts)
      : flow_(&flow), drifts_(drifts) {}

  Sampled operator()(const math::Vec3d& x, double t, math::Vec3d& v) {
    query::Location at;
    return sample(x, t, v, at);
  }

  Sampled sample(const math::Vec3d& x, double t, math::Vec3d& v, query::Location& at) {
    if (const Sampled s = flow_->sample(x, t, v, at); s != Sampled::inside)
      return s;
    for (const Drift& drift : drifts_)
      v += velocity_of(drift, flow_->sampler(), at, flow_->times(), t);
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z) ? Sampled::inside
                                                                          : Sampled::not_finite;
  }

  void accepted() { flow_->accepted(); }

  // See CellwiseField and ExitingField.
  bool confine(const math::Vec3d& x, const math::Vec3d& towards, double t) {
    return flow_->confine(x, towards, t);
  }
  void release() { flow_->release(); }
  double depth(const math::Vec3d& x, double t) { return flow_->depth(x, t); }
  double last_depth() const { return flow_->last_depth(); }
  Crossed cross(const math::Vec3d& x, const math::Vec3d& towards, double t) {
    return flow_->cross(x, towards, t);
  }
  std::optional<query::Exit> leave(const math::Vec3d& a, const math::Vec3d& b, double t,
                                   double dt) {
    return flow_->leave(a, b, t, dt);
  }

  math::Vec3d extent() { return flow_->extent(); }
  MeshVelocity& flow() { return *flow_; }

private:
  MeshVelocity* flow_;
  std::span<const Drift> drifts_;
};

} // namespace insitu::advect

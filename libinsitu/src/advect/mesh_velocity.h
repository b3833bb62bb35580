#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "advect/integrators.h"
#include "mesh/view.h"
#include "query/sampler.h"

namespace insitu::advect {

/// The velocity on a mesh between two committed steps, as integrate() asks for it. At time t, with
/// alpha = (t - t0) / (t1 - t0) in [0, 1], a point is located in (1 - alpha) earlier + alpha
/// current coordinates, and its velocity is (1 - alpha) earlier + alpha current velocity at that
/// place; a part of which there is no earlier state is taken as it is now. One object serves one
/// thread.
class MeshVelocity {
public:
  /// earlier may be null. The arguments must outlive the object.
  MeshVelocity(const query::Sampler& sampler, const mesh::FieldView& now,
               const mesh::FieldView* earlier, double t0, double t1, insitu_accuracy accuracy)
      : sampler_(&sampler), fields_{now, earlier ? *earlier : now}, blends_(earlier && t1 > t0),
        moves_(sampler.mesh().earlier_points && t1 > t0), t0_(t0), t1_(t1), accuracy_(accuracy) {}

  /// Begins with a new particle; hint: its last cell, or -1.
  void begin(std::int64_t hint) {
    const std::int64_t cells = sampler_->mesh().cell_count();
    hint_ = hint < cells ? hint : -1; // the mesh may have become smaller
    cell_ = sized_ = -1;
  }

  Sampled operator()(const math::Vec3d& x, double t, math::Vec3d& v) {
    query::Location at;
    return sample(x, t, v, at);
  }

  /// The same, and where x lies.
  Sampled sample(const math::Vec3d& x, double t, math::Vec3d& v, query::Location& at) {
    alpha_ = alpha(t);
    at = sampler_->locate(x, hint_, {accuracy_, moves_ ? alpha_ : 1.0});
    if (!at)
      return Sampled::outside;
    hint_ = at.cell;
    double u[6];
    sampler_->interpolate(std::span(fields_, blends_ ? 2 : 1), at, u);
    v = {u[0], u[1], u[2]};
    if (blends_)
      v = (1.0 - alpha_) * math::Vec3d{u[3], u[4], u[5]} + alpha_ * v;
    const bool finite = std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    return finite ? Sampled::inside : Sampled::not_finite;
  }

  void accepted() { cell_ = hint_; }

  /// How much of the current step there is at time t; of the geometry it is 1 if nothing moved.
  double alpha(double t) const {
    return t1_ > t0_ ? std::clamp((t - t0_) / (t1_ - t0_), 0.0, 1.0) : 1.0;
  }
  double geometry_alpha(double t) const { return moves_ ? alpha(t) : 1.0; }
  const query::Sampler& sampler() const { return *sampler_; }
  double interval() const { return t1_ - t0_; }

  /// The gradient of a component at a place and time, and the change with time of the velocity at a
  /// place in a cell (0 if the earlier velocity is unknown).
  math::Vec3d gradient(const query::Location& at, int component, double t) const {
    const math::Vec3d now = sampler_->gradient(fields_[0], component, at, geometry_alpha(t));
    if (!blends_)
      return now;
    const double a = alpha(t);
    return a * now + (1.0 - a) * sampler_->gradient(fields_[1], component, at, geometry_alpha(t));
  }
  math::Vec3d rate_of_change(const query::Location& at) const {
    if (!blends_)
      return {};
    double u[6];
    sampler_->interpolate(std::span(fields_, 2), at, u);
    return math::Vec3d{u[0] - u[3], u[1] - u[4], u[2] - u[5]} / interval();
  }
  insitu_accuracy accuracy() const { return accuracy_; }

  /// The cell of the particle's position (flat id), or -1 if it was never inside.
  std::int64_t cell() const { return cell_; }

  /// The bounding box of that cell; an edge far shorter than the others counts as 1e-6 of the
  /// longest.
  math::Vec3d extent() {
    if (sized_ != cell_) {
      sized_ = cell_;
      mesh::CellVertices c;
      mesh::gather(sampler_->mesh(), cell_, c, moves_ ? alpha_ : 1.0);
      math::Vec3d low = c.x[0], high = c.x[0];
      for (int i = 1; i < c.count; ++i)
        for (int a = 0; a < 3; ++a) {
          low[a] = std::min(low[a], c.x[i][a]);
          high[a] = std::max(high[a], c.x[i][a]);
        }
      extent_ = high - low;
      const double longest = std::max({extent_.x, extent_.y, extent_.z});
      const double least = std::max(1e-6 * longest, std::numeric_limits<double>::min());
      for (int a = 0; a < 3; ++a)
        extent_[a] = std::max(extent_[a], least);
    }
    return extent_;
  }

  bool blends_velocity() const { return blends_; }
  bool blends_geometry() const { return moves_; }

private:
  const query::Sampler* sampler_;
  mesh::FieldView fields_[2]; ///< now, earlier
  bool blends_, moves_;
  double t0_, t1_;
  insitu_accuracy accuracy_;
  double alpha_ = 1.0; ///< of the point asked last
  std::int64_t hint_ = -1;
  std::int64_t cell_ = -1;
  std::int64_t sized_ = -1; ///< the cell whose extent is kept
  math::Vec3d extent_;
};

} // namespace insitu::advect

#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

#include "advect/chart_motion.h"
#include "advect/integrators.h"
#include "mesh/view.h"
#include "query/sampler.h"

namespace insitu::advect {

/// The velocity on a mesh between two committed steps, as integrate() asks for it. At time t, with
/// alpha = (t - t0) / (t1 - t0) in [0, 1], a point is located in (1 - alpha) earlier + alpha
/// current coordinates, and its velocity is (1 - alpha) earlier + alpha current velocity at that
/// place; a part of which there is no earlier state is taken as it is now. One object serves one
/// thread.
///
/// On a geodetic mesh the field is metres per second east, north and up; the integrator's positions
/// are then those of ChartMotion, lengths are metres.
class MeshVelocity {
public:
  /// earlier may be null. The arguments must outlive the object.
  MeshVelocity(const query::Sampler& sampler, const mesh::FieldView& now,
               const mesh::FieldView* earlier, double t0, double t1, insitu_accuracy accuracy)
      : sampler_(sampler.among_images()), chart_(sampler.chart()), fields_{now, earlier ? *earlier : now}, blends_(earlier && t1 > t0),
        moves_(sampler.mesh().earlier_points && t1 > t0), t0_(t0), t1_(t1), accuracy_(accuracy) {}

  /// Begins with a new particle; hint: its last cell, or -1.
  void begin(std::int64_t hint) {
    const std::int64_t cells = sampler_.mesh().cell_count();
    hint_ = hint < cells ? hint : -1; // the mesh may have become smaller
    cell_ = sized_ = -1;
  }

  /// A particle's position in the mesh's frame, as integrate() has it, and back again.
  math::Vec3d enter(const math::Vec3d& position) {
    return chart_ ? chart_.enter(position) : position;
  }
  math::Vec3d position(const math::Vec3d& x) const { return chart_ ? chart_.position(x) : x; }

  Sampled operator()(const math::Vec3d& x, double t, math::Vec3d& v) {
    alpha_ = t1_ > t0_ ? std::clamp((t - t0_) / (t1_ - t0_), 0.0, 1.0) : 1.0;
    math::Vec3d image = x;
    if (chart_ && !chart_.image(x, image))
      return Sampled::outside;
    const query::Location at = sampler_.locate(image, hint_, {accuracy_, moves_ ? alpha_ : 1.0});
    if (!at)
      return Sampled::outside;
    hint_ = at.cell;
    double u[6];
    sampler_.interpolate(std::span(fields_, blends_ ? 2 : 1), at, u);
    v = {u[0], u[1], u[2]};
    if (blends_)
      v = (1.0 - alpha_) * math::Vec3d{u[3], u[4], u[5]} + alpha_ * v;
    if (chart_)
      v = chart_.rates(x, image, pole_of(at.cell), v);
    const bool finite = std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
    return finite ? Sampled::inside : Sampled::not_finite;
  }

  void accepted() { cell_ = hint_; }

  /// The cell of the particle's position (flat id), or -1 if it was never inside.
  std::int64_t cell() const { return cell_; }

  /// Between two steps of integrate().
  void settle(math::Vec3d& x, math::Vec3d& rate) {
    if (!chart_)
      return;
    const bool changed = chart_.settle(x, rate);
    sized_ = changed ? -1 : sized_;
  }

  /// Of a displacement or rate at x; metres on a geodetic mesh.
  double length(const math::Vec3d& x, const math::Vec3d& d) const {
    return chart_ ? chart_.length(x, d) : length_of(d);
  }

  /// The bounding box of that cell; an edge far shorter than the others counts as 1e-6 of the
  /// longest.
  math::Vec3d extent() {
    if (sized_ != cell_) {
      sized_ = cell_;
      mesh::CellVertices c;
      mesh::gather(sampler_.mesh(), cell_, c, moves_ ? alpha_ : 1.0);
      if (chart_)
        return extent_ = chart_.extent(c, pole_of(cell_));
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
  geo::Pole pole_of(std::int64_t cell) const {
    const mesh::MeshView& mesh = sampler_.mesh();
    return geo::Pole(mesh.pieces[mesh.piece_count == 1 ? 0 : mesh.piece_of(cell)].pole);
  }

  query::Sampler sampler_; ///< of the images
  ChartMotion chart_;
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

// The self-similar point blast of Sedov and Taylor in three dimensions: an ideal gas of uniform
// density, cold and at rest, in which an energy is released at a point at time zero.
#pragma once

#include <vector>

namespace sedov {

class SedovTaylor {
public:
  struct State {
    double density, pressure, velocity; // velocity: radial, outwards
  };

  // energy: released in all of space (an octant holds an eighth of it). Throws
  // std::invalid_argument unless 1 < gamma < 7 (from 7 on the centre is a vacuum and the
  // solution has another form) and the energy and density are positive.
  SedovTaylor(double gamma, double energy, double density);

  // The dimensionless energy: R = (energy * time^2 / (alpha * density))^(1/5).
  double alpha() const { return alpha_; }
  double shock_radius(double time) const;
  double shock_time(double radius) const; // the inverse
  State at(double radius, double time) const;

private:
  struct Entry {
    double log_radius; // over the shock radius
    // Logarithms of density over the density ahead and of pressure over (density ahead * shock
    // speed squared); velocity over (shock speed * radius / shock radius). And their derivatives
    // with respect to log_radius.
    double log_density, log_pressure, speed;
    double density_slope, pressure_slope, speed_slope;
  };
  double gamma_, energy_, density_, alpha_ = 0.0;
  std::vector<Entry> profile_; // from the shock inwards
};

} // namespace sedov

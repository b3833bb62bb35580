#include "advect/effects/inertia.h"

#include <cmath>

namespace insitu::advect {

namespace {

/// phi_0 to phi_4 at z, to a few hundred roundings.
template <class T>
void phi_functions(const T& z, T* phi) {
  constexpr double factorial[] = {1, 1, 2, 6, 24};
  phi[0] = std::exp(z);
  if (std::abs(z) >= 1.0) {
    for (int k = 0; k < 4; ++k)
      phi[k + 1] = (phi[k] - 1.0 / factorial[k]) / z;
    return;
  }
  for (int k = 1; k < 5; ++k) { // sum of z^j / (j + k)!
    T term = 1.0 / factorial[k], sum = term;
    for (int j = 1; j < 20; ++j) {
      term *= z / double(j + k);
      sum += term;
    }
    phi[k] = sum;
  }
}

} // namespace

LinearPart::LinearPart(const Inertia& inertia, double h) {
  const double rate = -h / inertia.response_time; // 0 without drag
  const double turns = length_of(inertia.rotation);
  if (turns > 0.0)
    axis_ = inertia.rotation / turns;
  phi_functions(rate, along_);
  phi_functions(std::complex<double>(rate, -2.0 * turns * h), around_);
}

Vec3d LinearPart::phi(int k, const Vec3d& w) const {
  if (axis_ == Vec3d{})
    return along_[k] * w;
  const Vec3d along = math::dot(w, axis_) * axis_, across = w - along;
  return along_[k] * along + around_[k].real() * across +
         around_[k].imag() * math::cross(axis_, across);
}

} // namespace insitu::advect

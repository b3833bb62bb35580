#include "cells/decide.h"

#include "cells/kernels.h"
#include "cells/robust_inverse.h"

namespace insitu::cells {

using math::Vec3d;

Reason decide(mesh::Shape shape, const Vec3d* x, const Vec3d& p) {
  return reason_of(contain_exact(shape, x, p));
}

Vec3d parametric_in(mesh::Shape shape, const Vec3d* x, const Vec3d& p) {
  const auto map = inverse_map(shape, x, p);
  return is_plausible(map.converged, map.margin) ? map.r : robust_inverse(shape, x, p);
}

} // namespace insitu::cells

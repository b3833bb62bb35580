#include "cells/decide.h"

#include "cells/kernels.h"
#include "cells/robust_inverse.h"

namespace insitu::cells {

using math::Vec3d;

Reason decide(mesh::Shape shape, const Vec3d* x, const Vec3d& p) {
  const ExactResult result = contain_exact(shape, x, p);
  switch (result.where) {
  case Containment::inside:
    return result.exact_used ? Reason::exact : Reason::certified;
  case Containment::on_face:
    return Reason::on_face;
  case Containment::on_edge:
    return Reason::on_edge;
  case Containment::on_vertex:
    return Reason::on_vertex;
  default:
    return Reason::outside;
  }
}

Vec3d parametric_in(mesh::Shape shape, const Vec3d* x, const Vec3d& p) {
  const auto map = inverse_map(shape, x, p);
  return is_plausible(map.converged, map.margin) ? map.r : robust_inverse(shape, x, p);
}

} // namespace insitu::cells

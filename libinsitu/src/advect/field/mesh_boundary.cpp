#include "advect/field/mesh_boundary.h"

#include <algorithm>

#include "advect/integrate/control.h"
#include "advect/integrate/fields.h"
#include "query/walk/beside_mesh.h"

namespace insitu::advect {

using math::Vec3d;

query::Location MeshBoundary::beside(const Moment& moment, const Vec3d& x, std::int64_t cell,
                                     double least_reach) {
  Vec3d inside = x;
  const double reach =
      std::max(least_reach, query::rounding_in(moment.mesh(), cell, moment.geometry_alpha()));
  const query::Location at = query::bring_inside(moment.sampler(), inside, reach, moment.options());
  if (at) {
    beside_ = x;
    alpha_ = moment.geometry_alpha();
    inside_ = inside;
  }
  return at;
}

bool MeshBoundary::beside_cell(const Moment& moment, const Vec3d& x, const KeptCell& cell) {
  Vec3d inside = x;
  if (!query::bring_into_cell(
          cell.vertices, inside,
          query::rounding_in(moment.mesh(), cell.cell, moment.geometry_alpha())))
    return false;
  beside_ = x;
  alpha_ = moment.geometry_alpha();
  inside_ = inside;
  return true;
}

double MeshBoundary::way_out(const Moment& moment, std::int64_t cell, const Vec3d& extent,
                             const Vec3d& a, const Vec3d& b) {
  const auto exit = query::leave_mesh(moment.sampler(), cell, a, b, moment.options());
  if (!exit)
    return -1.0;
  // What goes along a wall, and leaves further on, may by rounding be out of it at once.
  constexpr double no_way = control::on_face, some_way = 1e-3; // cells
  const double cells = cells_crossed(b - a, extent);
  if (exit->t * cells < no_way && cells > 0.0) {
    const Vec3d on = a + std::min(0.5, some_way / cells) * (b - a);
    if (moment.locate(on, cell) || beside(moment, on, cell))
      return -1.0;
  }
  return exit->t;
}

std::optional<query::Exit> MeshBoundary::leave(Moment& moment, std::int64_t cell, const Vec3d& a,
                                               const Vec3d& b, double t, double dt) const {
  moment.set(t);
  auto exit = query::leave_mesh(moment.sampler(), cell, a, b, moment.options());
  if (!exit || !moment.moves())
    return exit;
  // With the face where it is at part u of the way, it is left at part g(u): u = g(u) is wanted,
  // and g is as good as linear over so short a way.
  const auto left_at = [&](double u) {
    moment.set(t + u * dt);
    const query::Location at = moment.locate(a, cell);
    auto later =
        at ? query::leave_mesh(moment.sampler(), at.cell, a, b, moment.options()) : std::nullopt;
    if (later)
      exit = later;
    return bool(later);
  };
  const double g0 = exit->t;
  bool met = g0 == 0.0 || left_at(g0);
  if (met && g0 > 0.0) {
    const double u = g0 / (1.0 - (exit->t - g0) / g0);
    met = u >= 0.0 && u <= 1.0 && left_at(u);
    exit->t = u;
  }
  if (!met) { // the place where the face is when the particle is where it is
    moment.set(t);
    if ((exit = query::leave_mesh(moment.sampler(), cell, a, b, moment.options())))
      exit->t = 0.0;
  }
  return exit;
}

} // namespace insitu::advect

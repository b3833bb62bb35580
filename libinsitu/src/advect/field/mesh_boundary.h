#pragma once

#include <cstdint>
#include <limits>
#include <optional>

#include "advect/field/kept_cell.h"
#include "advect/field/moment.h"
#include "query/walk/face_crossing.h"

namespace insitu::advect {

/// The boundary of a mesh, as particles come to it: what lies beyond it by rounding alone counts as
/// inside, at a place in the mesh that stands for it; and a way that leaves the mesh has an exit.
class MeshBoundary {
public:
  /// Of a point that no cell holds: where it is in the mesh, if it lies beyond the mesh by rounding
  /// at the size of this cell, or by `least_reach`, and no more. Nothing for a point of a particle
  /// that was never in a cell (-1).
  query::Location beside(const Moment& moment, const math::Vec3d& x, std::int64_t cell,
                         double least_reach = 0.0);
  /// The same of a point that lies beyond this kept cell, at the moment, alone.
  bool beside_cell(const Moment& moment, const math::Vec3d& x, const KeptCell& cell);
  /// Whether inside() stands for x: the point that was found beside the mesh last, if the geometry
  /// is what it was.
  bool stands_for(const math::Vec3d& x, const Moment& moment) const {
    return x == beside_ && moment.geometry_alpha() == alpha_;
  }
  const math::Vec3d& inside() const { return inside_; }

  /// See ExitingField; cell: that of a, which is the particle's place at time t. The moment is then
  /// some time of the way.
  std::optional<query::Exit> leave(Moment& moment, std::int64_t cell, const math::Vec3d& a,
                                   const math::Vec3d& b, double t, double dt) const;
  /// See ExitingField; extent: of the cell.
  double way_out(const Moment& moment, std::int64_t cell, const math::Vec3d& extent,
                 const math::Vec3d& a, const math::Vec3d& b);

private:
  math::Vec3d beside_{std::numeric_limits<double>::quiet_NaN(), 0.0, 0.0}, inside_;
  double alpha_ = 1.0; ///< of the geometry in which inside_ stands for beside_
};

} // namespace insitu::advect

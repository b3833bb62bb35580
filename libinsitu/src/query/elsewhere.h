#pragma once

#include <exception>
#include <optional>
#include <vector>

#include "math/vec.h"
#include "query/location.h"

/// Points that no cell of this process holds, while cells of other processes may.
namespace insitu::query {

class Outlook;

/// Thrown for such a point: what asked for it cannot go on before the other processes have told
/// what they have there.
struct Elsewhere final : std::exception {
  Elsewhere(const Outlook& who, const math::Vec3d& at, double of_geometry, double within = 0.0)
      : outlook(&who), point(at), alpha(of_geometry), reach(within) {}
  const char* what() const noexcept override { return "a place that another process may hold"; }

  const Outlook* outlook; ///< which has to know
  math::Vec3d point;
  double alpha; ///< of the geometry: see LocateOptions
  double reach; ///< 0: the cell that holds the point is wanted; else Outlook::nearest()
};

/// Knows about points that no cell here holds. Its calls are const and thread-safe.
class Outlook {
public:
  virtual ~Outlook() = default;
  /// Whether another process may have a cell that holds the point.
  virtual bool is_beyond(const math::Vec3d& point) const = 0;
  /// The place of such a point in a cell of another process, which the sampler's mesh then has, or
  /// none where no process holds it. Throws Elsewhere where that is not known.
  virtual Location find(const math::Vec3d& point, double alpha) const = 0;
  /// Of a point that no process holds, and that is not near to cells here: the nearest point in
  /// other processes' cells, if it lies within reach along each axis. Throws Elsewhere where that
  /// is not known.
  virtual std::optional<math::Vec3d> nearest(const math::Vec3d& point, double reach,
                                             double alpha) const = 0;
  /// The other processes that may hold a point, or a point within reach of it.
  virtual std::vector<int> ranks_at(const math::Vec3d& point, double reach) const = 0;
  /// From now on find() and nearest() ask `who`; null: points beyond are in no cell.
  virtual void ask(const Outlook* /*who*/) const {}
};

} // namespace insitu::query

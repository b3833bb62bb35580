#pragma once

#include <exception>

#include "math/vec.h"

/// Points that no cell of this process holds, while cells of other processes may.
namespace insitu::query {

/// Thrown for such a point: what asked for it cannot go on before the other processes have told who
/// holds it.
struct Elsewhere final : std::exception {
  Elsewhere(const math::Vec3d& at, double of_geometry) : point(at), alpha(of_geometry) {}
  const char* what() const noexcept override { return "a place that another process may hold"; }

  math::Vec3d point;
  double alpha; ///< of the geometry: see LocateOptions
  /// Whether a value at the point, at this time, is all that is wanted: who holds it does then not
  /// matter.
  bool is_for_value = false;
  double time = 0.0;
};

/// Knows about points that no cell here holds.
class Outlook {
public:
  virtual ~Outlook() = default;
  /// Throws Elsewhere unless it is known that no other process has a cell that holds the point.
  /// Called from many threads at once.
  virtual void missed(const math::Vec3d& point, double alpha) const = 0;
};

} // namespace insitu::query

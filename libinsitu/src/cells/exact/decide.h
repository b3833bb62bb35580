#pragma once

#include <cmath>
#include <cstdint>

#include "cells/exact/contain_exact.h"
#include "math/hd.h"

/// What every locator decides of a point and one cell: whether the cell holds it, and where in it.
namespace insitu::cells {

/// Why a point has the owner that it has; the values of insitu_reason.
enum class Reason : std::uint8_t {
  outside,   ///< no owning cell holds it
  certified, ///< strictly inside its owner, proven in floating point
  exact,     ///< strictly inside its owner, by exact arithmetic
  on_face,   ///< on a face of its owner: the lowest id of the cells there
  on_edge,   ///< the same, on an edge
  on_vertex, ///< the same, on a vertex
};
constexpr int reason_count = 6;

/// The reason that a result of contain_exact is.
INSITU_HD inline Reason reason_of(const ExactResult& result) {
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

/// What is decided of a point and one cell: the reason, and on which of its faces, edges or
/// vertices (by Containment's numbers) the point lies, where it lies on one. In one byte.
class Decision {
public:
  constexpr Decision() = default; ///< outside
  INSITU_HD constexpr explicit Decision(Reason reason, int feature = -1)
      : code_(std::uint8_t(unsigned(reason) | unsigned(feature + 1) << 3)) {}
  INSITU_HD static constexpr Decision from_code(std::uint8_t code) {
    return Decision(Reason(code & 7), (code >> 3) - 1);
  }

  INSITU_HD constexpr std::uint8_t code() const { return code_; }
  INSITU_HD constexpr Reason reason() const { return Reason(code_ & 7); }
  INSITU_HD constexpr int feature() const { return (code_ >> 3) - 1; }
  INSITU_HD constexpr bool is_on_boundary() const { return code_ > 7; }
  /// Whether the closed cell holds the point.
  INSITU_HD constexpr explicit operator bool() const { return reason() != Reason::outside; }

private:
  std::uint8_t code_ = 0;
};
INSITU_HD inline Decision decision_of(const ExactResult& result) {
  return Decision(reason_of(result), result.feature);
}

/// Whether the closed cell holds the point, and why: exact. x: the cell's vertices.
Decision decide(mesh::Shape shape, const math::Vec3d* x, const math::Vec3d& p);

/// Whether what Newton found in a cell that holds the point is where it lies.
INSITU_HD inline bool is_plausible(bool converged, double margin) {
  return converged && margin >= -1e-3;
}

/// The parametric coordinates of a point in a cell that holds it; on the face, edge or vertex that
/// the decision names, or that is as near as rounding, exactly (on_feature.h).
math::Vec3d parametric_in(mesh::Shape shape, const math::Vec3d* x, const math::Vec3d& p,
                          const Decision& decision = {});

} // namespace insitu::cells

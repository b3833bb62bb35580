#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "core/memory.h"
#include "core/parallel.h"
#include "math/vec.h"
#include "mesh/box.h"

namespace insitu::accel {

/// Where a ray meets a triangle: the distance, and the weights of the second and third vertex.
struct TriangleHit {
  std::uint32_t triangle = 0;
  double t = 0, u = 0, v = 0;
};

/// Triangles for rays, both sides alike (Embree). Rays do not slip through between triangles that
/// share vertices.
class TriangleRays {
public:
  using Ids = std::array<std::uint32_t, 3>;

  /// Coordinates and triangles must outlive this and are finite. bounds: of all triangles of which
  /// these may be a part, each of which answers alike in any part; null: of these. Throws
  /// core::Error.
  TriangleRays(std::span<const math::Vec3d> points, std::span<const Ids> triangles,
               const mesh::Box* bounds, const core::Threads& threads, core::Memory& memory);
  ~TriangleRays();
  TriangleRays(const TriangleRays&) = delete;
  TriangleRays& operator=(const TriangleRays&) = delete;

  /// Calls met(hit) for the triangles that the ray meets between t_min and t_max, in no order, and
  /// for those that share the place twice or so; true: what lies behind the hit does not count.
  /// The direction has length 1. Distances are computed in double from the triangle's plane; which
  /// triangles are met is decided in float, within 1e-6 of the mesh's extent. Thread-safe.
  void meet(const math::Vec3d& origin, const math::Vec3d& direction, double t_min, double t_max,
            core::FunctionRef<bool(const TriangleHit&)> met) const;

  /// From the lowest to the highest corner of the bounds.
  double extent() const;
  std::int64_t bytes() const;

private:
  struct Scene;
  std::unique_ptr<Scene> scene_;
};

} // namespace insitu::accel

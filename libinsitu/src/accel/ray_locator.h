#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "accel/locator.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::accel {

class MeshFaces;

/// Sizes of a ray method's structures.
struct RayLocatorReport {
  std::int64_t primitives = 0; ///< triangles, or cells
  std::int64_t groups = 0;     ///< of the two-level structure; 1: one level
  std::int64_t bytes = 0;      ///< held, the backend's included
  std::int64_t peak_bytes = 0; ///< the most during the last build
};

/// A ray method on the CPU (Embree): finds a candidate for each point by the papers' rules. Who
/// asks for exact answers verifies it (query/).
class RayLocator {
public:
  virtual ~RayLocator() = default;
  /// Builds over all owning cells. faces: of this mesh, for methods that use them, else null. Both
  /// are read by the other calls, too. Throws core::Error.
  virtual void build(const mesh::MeshView& mesh, const MeshFaces* faces,
                     const core::Threads& threads) = 0;
  /// Follows moved vertices; the cells are those that were built.
  virtual void refit(const mesh::MeshView& mesh, const core::Threads& threads) = 0;
  /// cells[i]: the flat id of the cell that the rule tells for points[i], or -1. beyond: of the
  /// same size, or empty: the cell on the other side of the face that the ray hit, or -1.
  /// Thread-safe.
  virtual void find(std::span<const math::Vec3d> points, std::span<std::int64_t> cells,
                    std::span<std::int64_t> beyond = {}) const = 0;
  virtual RayLocatorReport report() const = 0;
};

/// group: primitives a bottom structure holds at most.
std::unique_ptr<RayLocator> make_embree_locator(Method method, core::Memory& memory,
                                                std::int64_t group = std::int64_t(1) << 20);

} // namespace insitu::accel

#pragma once

#include <cstdint>
#include <span>

#include "accel/faces/face_triangle.h"
#include "core/memory.h"
#include "core/parallel.h"
#include "mesh/view.h"

namespace insitu::accel {

/// Faces of the owning cells, shared ones once, and their triangles for the face methods.
class MeshFaces {
public:
  explicit MeshFaces(core::Memory& memory);

  /// Finds and matches the faces: by ids, the same triangle or the same cyclic quad. Two cells
  /// share a face; further ones with the same face get one of their own (crowded_faces()). Repeated
  /// vertices make a triangle of a quad, or nothing. The same faces in the same order for any
  /// thread count. Throws INSITU_ERROR_MESH above 2^32 - 1 vertices.
  void build(const mesh::MeshView& mesh, const core::Threads& threads);

  /// At most what it holds at once while it is built, without scratch of threads.
  static std::int64_t most_bytes_while_built(const mesh::MeshView& mesh,
                                             const core::Threads& threads);

  /// A face and the cells that have it.
  struct Face {
    std::uint32_t vertices[4]; ///< cyclic, outward from `cell`; [3] is `none` for triangles
    std::uint32_t cell, other; ///< `none` on the boundary
  };
  std::span<const Face> faces() const { return faces_.span(); }

  std::int64_t face_count() const { return std::int64_t(faces_.size()); }
  std::int64_t boundary_faces() const { return boundary_; } ///< of one cell alone
  std::int64_t crowded_faces() const { return crowded_; }   ///< of three cells or more
  /// Of two cells that turn it the same way: they are on the same side, or one is inverted.
  std::int64_t turned_faces() const { return turned_; }
  /// Boundary quads that meet a boundary triangle, or their own corners in another cyclic order.
  std::int64_t split_faces() const { return split_; }
  std::int64_t bytes() const { return std::int64_t(faces_.bytes()); }

  /// The triangles of a face method, for the coordinates as they are now: curved quads have
  /// bounding tetrahedra (`shared_bilinear_faces`), else two triangles along the diagonal of the
  /// quad's canonical corner. After the vertices moved the same table gives the triangles anew;
  /// their number may differ for shared_bilinear_faces, since planar quads are recognised exactly.
  void triangles(const mesh::MeshView& mesh, const core::Threads& threads, Method method,
                 core::Buffer<FaceTriangle>& out) const;

  /// The largest distance of two vertices of a cell, as a float rounded up.
  static float longest_distance(const mesh::MeshView& mesh, const core::Threads& threads);

private:
  core::Memory* memory_;
  core::Buffer<Face> faces_; ///< in the order of their lowest vertices, roughly
  std::int64_t boundary_ = 0, crowded_ = 0, turned_ = 0, split_ = 0;
};

} // namespace insitu::accel

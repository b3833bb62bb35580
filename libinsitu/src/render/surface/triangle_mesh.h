#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "accel/camera_rays/triangle_rays.h"
#include "core/counted_vector.h"
#include "core/parallel.h"
#include "mesh/view.h"
#include "query/sampler.h"
#include "render/structures/chart_copies.h"

namespace insitu::render {

/// Triangles as a file has them, three corners each.
struct TriangleList {
  std::string source; ///< the file's path
  core::CountedVector<math::Vec3d> corners;
};

/// Reads STL, ASCII or binary (told apart by the size that a binary file states). Throws
/// core::Error (INSITU_ERROR_FILE, or INSITU_ERROR_SCENE for what is no STL) with the file and the
/// place.
TriangleList read_stl(const std::string& path,
                      const core::CountedAllocator<math::Vec3d>& allocator = {});

/// Triangles to be drawn.
class TriangleMesh {
public:
  /// The faces of owning cells that no other cell has, each quad as two triangles along the
  /// diagonal of its canonical corner: good to look at, not the exact boundary of curved cells.
  /// Faces of different pieces meet if their corners have the same coordinates, and those of leaves
  /// of an adaptive mesh, of one depth or several, as remove_faces_inside() says. bounds: of the
  /// whole mesh, of which this may be the part of one process: rays meet each part as the whole.
  /// copies: of a chart that has some, over whose seam faces meet, too; else null.
  static std::unique_ptr<TriangleMesh> boundary(const mesh::MeshView& mesh, const mesh::Box& bounds,
                                                const ChartCopies* copies,
                                                const core::Threads& threads, core::Memory& memory);
  static std::unique_ptr<TriangleMesh> body(const TriangleList& list, const core::Threads& threads,
                                            core::Memory& memory);

  const accel::TriangleRays& rays() const { return *rays_; }
  /// As boundary() was given them; nothing of a body.
  const mesh::Box& bounds() const { return bounds_; }
  std::int64_t count() const { return std::int64_t(triangles_.size()); }
  std::int64_t bytes() const;
  /// About what bytes() will be, of a body of so many triangles; and of the boundary of a mesh that
  /// fills its box, by a look at some cells.
  static std::int64_t bytes_about(std::int64_t triangles);
  static std::int64_t bytes_about(const query::Sampler& sampler);
  /// At most what a boundary takes besides while it is made.
  static std::int64_t most_bytes_while_made(const mesh::MeshView& mesh,
                                            const core::Threads& threads);

  /// The flat cell that has the triangle; -1 for a body.
  std::int64_t cell(std::uint32_t triangle) const {
    return cells_.empty() ? -1 : std::int64_t(cells_[triangle]);
  }
  /// Flat ids of a boundary triangle's vertices.
  void vertices(std::uint32_t triangle, std::uint32_t (&ids)[3]) const {
    for (std::size_t k = 0; k < 3; ++k)
      ids[k] = vertices_[triangles_[triangle][k]];
  }
  /// Across the triangle, of the length of its area twice.
  math::Vec3d normal(std::uint32_t triangle) const {
    const accel::TriangleRays::Ids& ids = triangles_[triangle];
    return cross(points_[ids[1]] - points_[ids[0]], points_[ids[2]] - points_[ids[0]]);
  }

private:
  explicit TriangleMesh(core::Memory& memory);
  void build(const core::Threads& threads, const mesh::Box* bounds);

  core::Memory* memory_;
  core::Buffer<math::Vec3d> points_;
  core::Buffer<accel::TriangleRays::Ids> triangles_;
  core::Buffer<std::uint32_t> vertices_, cells_;
  mesh::Box bounds_{};
  std::unique_ptr<accel::TriangleRays> rays_;
};

} // namespace insitu::render

#pragma once

#include "accel/embree/grouped_scene.h"
#include "accel/faces/mesh_faces.h"
#include "accel/ray_locator.h"

namespace insitu::accel::embree {

/// The face methods: short rays at the triangles of a MeshFaces, which must outlive this, as must
/// the mesh.
class FaceRays final : public RayLocator {
public:
  FaceRays(Method method, core::Memory& memory, std::int64_t group);

  void build(const mesh::MeshView& mesh, const MeshFaces* faces,
             const core::Threads& threads) override;
  void refit(const mesh::MeshView& mesh, const core::Threads& threads) override;
  void find(std::span<const math::Vec3d> points, std::span<std::int64_t> cells,
            std::span<std::int64_t> beyond) const override;
  RayLocatorReport report() const override;

private:
  void set_vertices(const mesh::MeshView& mesh, const core::Threads& threads);
  void build_scene(const core::Threads& threads);
  std::uint32_t cell_at(const FaceTriangle& triangle, bool hit_back, const math::Vec3d& p,
                        const math::Vec3f& local) const;

  Method method_;
  std::int64_t group_;
  const mesh::MeshView* mesh_ = nullptr;
  const MeshFaces* faces_ = nullptr;
  math::Vec3d origin_;
  float length_ = 0.0f;
  std::int64_t vertex_count_ = 0;
  core::Buffer<float> vertices_; ///< x, y, z from the origin, and padding: Embree reads 16 bytes
  core::Buffer<FaceTriangle> triangles_;
  Device device_;
  GroupedScene scene_{device_};
};

} // namespace insitu::accel::embree

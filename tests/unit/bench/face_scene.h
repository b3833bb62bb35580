#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "accel/embree/device.h"
#include "accel/faces/mesh_faces.h"
#include "accel/rays/ray_rules.h"
#include "accel/tree/owners.h"
#include "commit/committed_mesh.h"
#include "core/context.h"
#include "workload/mesh.h"

namespace insitu::test {

/// The triangles of a face method over a box of hexahedra as an Embree scene of its own, whose hits
/// are counted.
class FaceScene {
public:
  FaceScene(accel::Method method, std::int64_t cells, bool counts = true)
      : context_(1, core::Log()), committed_("faces", context_.memory),
        triangles_(context_.memory, INSITU_MEMORY_TREE), faces_(context_.memory),
        device_(context_.memory) {
    using namespace workload;
    box_ = make_box(Kind::hexahedra, box_size(Kind::hexahedra, cells), 0.2);
    const insitu_array points =
        insitu_array_of(box_.points.data(), INSITU_FLOAT64, box_.vertex_count(), 3);
    committed_.mesh().set_points(0, &points, 1);
    insitu_cells given = insitu_cells_default();
    given.count = box_.cell_count();
    given.shape = insitu_shape(box_.uniform_shape);
    given.connectivity = insitu_array_of(box_.connectivity.data(), INSITU_INT32, given.count, 8);
    committed_.mesh().set_cells(0, &given);
    committed_.commit(context_.threads, context_.log, context_.memory, true);
    const mesh::MeshView& view = committed_.mesh().view();
    faces_.build(view, context_.threads);
    faces_.triangles(view, context_.threads, method, triangles_);
    origin_ = accel::Owners(view, context_.threads).origin();
    length_ = accel::MeshFaces::longest_distance(view, context_.threads) * 1.0001f;
    for (std::int64_t v = 0; v < view.vertex_count(); ++v) {
      const math::Vec3d d = view.pieces[0].point(v) - origin_;
      for (int a = 0; a < 3; ++a)
        vertices_.push_back(float(d[a]));
    }
    vertices_.push_back(0.0f); // Embree reads 16 bytes a vertex
    scene_ = rtcNewScene(device_.handle());
    rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
    RTCGeometry g = rtcNewGeometry(device_.handle(), RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertices_.data(), 0,
                               3 * sizeof(float), std::size_t(view.vertex_count()));
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles_.data(), 0,
                               sizeof(accel::FaceTriangle), triangles_.size());
    rtcSetGeometryUserData(g, this);
    culls_ = method == accel::Method::replicated_faces;
    if (counts)
      rtcSetGeometryIntersectFilterFunction(g, count);
    rtcCommitGeometry(g);
    rtcAttachGeometry(scene_, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(scene_);
  }
  ~FaceScene() { rtcReleaseScene(scene_); }
  FaceScene(const FaceScene&) = delete;
  FaceScene& operator=(const FaceScene&) = delete;

  RTCScene handle() const { return scene_; }
  const workload::Mesh& box() const { return box_; }
  std::int64_t triangles() const { return std::int64_t(triangles_.size()); }
  std::int64_t hits() const { return hits_; } ///< of triangles, by all rays so far
  accel::PointRay ray(const math::Vec3d& p) const { return accel::point_ray(p, origin_, length_); }

private:
  static void count(const RTCFilterFunctionNArguments* args) {
    auto& scene = *static_cast<FaceScene*>(args->geometryUserPtr);
    for (unsigned i = 0; i < args->N; ++i) {
      if (args->valid[i] == 0)
        continue;
      ++scene.hits_;
      const float side =
          RTCHitN_Ng_x(args->hit, args->N, i) * RTCRayN_dir_x(args->ray, args->N, i) +
          RTCHitN_Ng_y(args->hit, args->N, i) * RTCRayN_dir_y(args->ray, args->N, i) +
          RTCHitN_Ng_z(args->hit, args->N, i) * RTCRayN_dir_z(args->ray, args->N, i);
      if (scene.culls_ && side > 0.0f)
        args->valid[i] = 0; // from behind
    }
  }

  core::Context context_;
  workload::Mesh box_;
  commit::CommittedMesh committed_;
  core::Buffer<accel::FaceTriangle> triangles_;
  accel::MeshFaces faces_;
  accel::embree::Device device_;
  RTCScene scene_ = nullptr;
  std::vector<float> vertices_;
  math::Vec3d origin_;
  float length_ = 0.0f;
  bool culls_ = false;
  std::int64_t hits_ = 0;
};

} // namespace insitu::test

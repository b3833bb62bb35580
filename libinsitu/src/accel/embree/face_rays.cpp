#include "accel/embree/face_rays.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "accel/rays/ray_rules.h"
#include "accel/tree/node.h"
#include "accel/tree/owners.h"
#include "cells/exact/contain_exact.h"

namespace insitu::accel::embree {

using math::Vec3d;
using math::Vec3f;

namespace {

constexpr std::int64_t grain = 4096;

/// Hits from behind do not count.
void keep_front(const RTCFilterFunctionNArguments* args) {
  for (unsigned i = 0; i < args->N; ++i) {
    if (args->valid[i] == 0)
      continue;
    const float side = RTCHitN_Ng_x(args->hit, args->N, i) * RTCRayN_dir_x(args->ray, args->N, i) +
                       RTCHitN_Ng_y(args->hit, args->N, i) * RTCRayN_dir_y(args->ray, args->N, i) +
                       RTCHitN_Ng_z(args->hit, args->N, i) * RTCRayN_dir_z(args->ray, args->N, i);
    if (side > 0.0f)
      args->valid[i] = 0;
  }
}

} // namespace

FaceRays::FaceRays(Method method, core::Memory& memory, std::int64_t group)
    : method_(method), group_(group), vertices_(memory, INSITU_MEMORY_TREE),
      triangles_(memory, INSITU_MEMORY_TREE), device_(memory) {}

void FaceRays::build(const mesh::MeshView& mesh, const MeshFaces* faces,
                     const core::Threads& threads) {
  scene_.clear();
  mesh_ = &mesh;
  faces_ = faces;
  faces_->triangles(mesh, threads, method_, triangles_);
  set_vertices(mesh, threads);
  build_scene(threads);
}

void FaceRays::refit(const mesh::MeshView& mesh, const core::Threads& threads) {
  mesh_ = &mesh;
  const std::size_t before = triangles_.size();
  const FaceTriangle* at = triangles_.data();
  faces_->triangles(mesh, threads, method_, triangles_);
  const bool same = triangles_.size() == before && triangles_.data() == at;
  if (!same)
    scene_.clear();
  set_vertices(mesh, threads);
  if (!same) {
    build_scene(threads);
    return;
  }
  // Triangles may turn or take the other diagonal; refits read the indices anew, and a face's
  // triangles are where they were.
  device_.reset_peak();
  scene_.refit(threads, [](RTCGeometry geometry) {
    rtcUpdateGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0);
  });
}

/// The frame is fitted to the mesh each time, as the tree's is.
void FaceRays::set_vertices(const mesh::MeshView& mesh, const core::Threads& threads) {
  origin_ = Owners(mesh, threads).origin();
  vertex_count_ = mesh.vertex_count();
  vertices_.resize_discard(3 * std::size_t(vertex_count_) + 4);
  std::fill_n(vertices_.end() - 4, 4, 0.0f);
  for (std::int32_t p = 0; p < mesh.piece_count; ++p) {
    const std::int64_t first = mesh.first_vertex[p];
    threads.parallel_for(mesh.first_vertex[p + 1] - first, grain,
                         [&](std::int64_t begin, std::int64_t end) {
                           for (std::int64_t v = begin; v < end; ++v) {
                             const Vec3d d = mesh.pieces[p].point(v) - origin_;
                             for (int a = 0; a < 3; ++a)
                               vertices_[std::size_t(3 * (first + v) + a)] = float(d[a]);
                           }
                         });
  }
  length_ = MeshFaces::longest_distance(mesh, threads) * 1.0001f;
}

void FaceRays::build_scene(const core::Threads& threads) {
  device_.reset_peak();
  scene_.build(
      std::int64_t(triangles_.size()), group_, threads, [&](std::int64_t begin, std::int64_t end) {
        RTCGeometry g = rtcNewGeometry(device_.handle(), RTC_GEOMETRY_TYPE_TRIANGLE);
        rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                   vertices_.data(), 0, 3 * sizeof(float),
                                   std::size_t(vertex_count_));
        rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles_.data(),
                                   std::size_t(begin) * sizeof(FaceTriangle), sizeof(FaceTriangle),
                                   std::size_t(end - begin));
        if (method_ == Method::replicated_faces)
          rtcSetGeometryIntersectFilterFunction(g, keep_front);
        return g;
      });
}

std::uint32_t FaceRays::cell_at(const FaceTriangle& triangle, bool hit_back, const Vec3d& p,
                                const Vec3f& local) const {
  if (method_ == Method::replicated_faces) {
    mesh::CellVertices cell;
    mesh::gather(*mesh_, triangle.front, cell);
    return cells::holds(cells::contain_exact(cell.shape, cell.x, p).where) ? triangle.front : none;
  }
  return cell_of_hit(triangle, hit_back, [&](const FaceTriangle& t) {
    Vec3d quad[4]; // the ray's own vertices, so that the tetrahedron is the one that it hit
    const std::uint32_t ids[4] = {t.vertices[0], t.vertices[1], t.vertices[2], t.corner};
    for (int k = 0; k < 4; ++k) {
      const float* x = &vertices_[3 * std::size_t(ids[k])];
      quad[k] = {x[0], x[1], x[2]};
    }
    return is_beside(quad, Vec3d{local.x, local.y, local.z});
  });
}

void FaceRays::find(std::span<const Vec3d> points, std::span<std::int64_t> cells,
                    std::span<std::int64_t> beyond) const {
  const auto id = [](std::uint32_t cell) { return cell == none ? -1 : std::int64_t(cell); };
  for (std::size_t i = 0; i < points.size(); ++i) {
    cells[i] = -1;
    if (!beyond.empty())
      beyond[i] = -1;
    const PointRay ray = point_ray(points[i], origin_, length_);
    const RTCHit hit = trace(scene_, ray);
    if (hit.geomID == RTC_INVALID_GEOMETRY_ID)
      continue;
    const FaceTriangle& triangle = triangles_[std::size_t(scene_.primitive(hit))];
    const Vec3f& d = ray.direction;
    const bool back = hit.Ng_x * d.x + hit.Ng_y * d.y + hit.Ng_z * d.z > 0.0f;
    const std::uint32_t cell = cell_at(triangle, back, points[i], ray.origin);
    cells[i] = id(cell);
    if (!beyond.empty() && method_ != Method::replicated_faces)
      beyond[i] = id(cell == triangle.front ? triangle.back : triangle.front);
  }
}

RayLocatorReport FaceRays::report() const {
  const auto held = std::int64_t(vertices_.bytes() + triangles_.bytes());
  return {std::int64_t(triangles_.size()), scene_.groups(), held + device_.bytes(),
          held + device_.peak_bytes()};
}

} // namespace insitu::accel::embree

#pragma once

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "accel/faces/mesh_faces.h"
#include "fixtures/committed.h"
#include "on_device.h"
#include "query/device/device_locator.h"

/// What tests of ray methods on a device need: meshes with their faces, points that try to break
/// them, device memory, and the CPU's exact answers.
namespace insitu::test {

inline const accel::Method ray_methods[] = {
    accel::Method::user_geometry, accel::Method::replicated_faces, accel::Method::shared_faces,
    accel::Method::shared_bilinear_faces};

/// Random points of the box and around it, on faces, edges and vertices, and such that are nowhere.
inline std::vector<math::Vec3d> hard_points(const TestMesh& mesh, int count, std::uint64_t seed) {
  Random random(seed);
  std::vector<math::Vec3d> points;
  const math::Vec3d size = mesh.high - mesh.low;
  for (int i = 0; i < count; ++i) {
    const MeshCell& cell = mesh.cells[std::size_t(random.below(int(mesh.cells.size())))];
    const Vertices x = mesh.cell_vertices(cell);
    if (i % 3 == 0)
      points.push_back(random.uniform(mesh.low - 0.1 * size, mesh.high + 0.1 * size));
    else
      points.push_back(adversarial_point(cell.shape, x.data(), random, i % 2 == 0));
  }
  const double nan = std::numeric_limits<double>::quiet_NaN(), inf = HUGE_VAL;
  for (const double bad : {nan, inf, -inf, 1e300, -1e39, 3e37})
    for (int a = 0; a < 3; ++a) {
      math::Vec3d p = 0.5 * (mesh.low + mesh.high);
      p[a] = bad;
      points.push_back(p);
    }
  return points;
}

/// A mesh of every kind of cell, and of hard ones.
struct Case {
  const char* name;
  MeshOptions options;
};
inline const Case cases[] = {
    {"tetrahedra", {.kind = MeshKind::tetrahedra, .size = 5, .jitter = 0.25}},
    {"hexahedra", {.kind = MeshKind::hexahedra, .size = 9, .jitter = 0.2}},
    {"flat hexahedra", {.kind = MeshKind::hexahedra, .size = 6, .jitter = 0.0}},
    {"twisted", {.kind = MeshKind::hexahedra, .size = 8, .jitter = 0.4}},
    {"folded", {.kind = MeshKind::hexahedra, .size = 6, .jitter = 0.9}},
    {"wedges", {.kind = MeshKind::wedges, .size = 6, .jitter = 0.25}},
    {"pyramids", {.kind = MeshKind::pyramids, .size = 5, .jitter = 0.25}},
    {"voxels", {.kind = MeshKind::voxels, .size = 7}},
    {"mixed", {.kind = MeshKind::mixed, .size = 6, .jitter = 0.3}},
    {"long", {.kind = MeshKind::mixed, .size = 6, .jitter = 0.3, .scale = {1, 200, 0.01}}},
    {"far", {.kind = MeshKind::mixed, .size = 6, .jitter = 0.3, .offset = 6.4e6}},
    {"collapsed", {.kind = MeshKind::hexahedra, .size = 7, .jitter = 0.2, .collapse = 0.2}},
    {"snapped", {.kind = MeshKind::mixed, .size = 6, .jitter = 0.3, .snap = 0.125}},
    {"one", {.kind = MeshKind::hexahedra, .size = 1, .jitter = 0.0}},
};

/// The mesh as it is, as an query::HostView.
struct OwnView {
  const mesh::Mesh* mesh;
  const mesh::MeshView& operator()() const { return mesh->view(); }
};
inline OwnView view_of(const mesh::Mesh& mesh) {
  return {&mesh};
}

/// A mesh with the tree on the CPU and its faces.
struct RayMesh {
  RayMesh(const RayMesh&) = delete;
  RayMesh& operator=(const RayMesh&) = delete;
  explicit RayMesh(const TestMesh& mesh) : on_cpu(mesh), faces(on_cpu.memory) {
    faces.build(view(), on_cpu.threads);
  }
  const mesh::MeshView& view() const { return on_cpu.mesh.mesh().view(); }

  void commit(query::DeviceLocator& locator, std::uint32_t what = INSITU_CHANGED_ALL) {
    locator.commit(on_cpu.mesh.mesh(), host(), what, &faces, on_cpu.threads);
  }
  query::HostView host() const { return host_; }
  std::vector<query::Location> exact(const std::vector<math::Vec3d>& points) const {
    std::vector<query::Location> out(points.size());
    on_cpu.sampler().locate(on_cpu.threads, points, out, {.accuracy = INSITU_EXACT});
    return out;
  }

  fixtures::Committed on_cpu;
  accel::MeshFaces faces;

private:
  struct View {
    const RayMesh* mesh;
    const mesh::MeshView& operator()() const { return mesh->view(); }
  };
  View host_{this};
};

/// The cells that the locator tells for points in host memory.
inline std::vector<std::int64_t> cells_of(const query::DeviceLocator& locator,
                                          const std::vector<math::Vec3d>& points,
                                          insitu_accuracy accuracy,
                                          query::DeviceCounts* counts = nullptr) {
  std::vector<std::int64_t> cells(points.size(), -7);
  query::DeviceQuery query;
  query.points = &points[0].x;
  query.count = std::int64_t(points.size());
  query.accuracy = accuracy;
  query.cells = cells.data();
  const query::DeviceCounts c = locator.locate(query);
  if (counts)
    *counts = c;
  return cells;
}

} // namespace insitu::test

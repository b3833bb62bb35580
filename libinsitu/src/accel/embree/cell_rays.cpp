#include "accel/embree/cell_rays.h"

#include <algorithm>

#include "accel/rays/ray_rules.h"
#include "accel/tree/owners.h"
#include "cells/exact/contain_exact.h"

namespace insitu::accel::embree {

using math::Vec3d;

namespace {

/// What a ray looks for; Embree calls back on the thread that traces.
struct Search {
  Vec3d point;
  std::int64_t cell = -1;
};
thread_local Search search;

} // namespace

CellRays::CellRays(core::Memory& memory, std::int64_t group)
    : group_(group), cells_(memory, INSITU_MEMORY_TREE), boxes_(memory, INSITU_MEMORY_BUILD),
      device_(memory) {}

void CellRays::build(const mesh::MeshView& mesh, const MeshFaces*, const core::Threads& threads) {
  scene_.clear();
  set_boxes(mesh, threads);
  device_.reset_peak();
  const auto n = std::int64_t(cells_.size());
  groups_.clear();
  groups_.reserve(std::size_t((n + group_ - 1) / group_)); // Embree points to them
  scene_.build(n, group_, threads, [&](std::int64_t begin, std::int64_t end) {
    RTCGeometry g = rtcNewGeometry(device_.handle(), RTC_GEOMETRY_TYPE_USER);
    groups_.push_back({this, std::size_t(begin)});
    rtcSetGeometryUserPrimitiveCount(g, unsigned(end - begin));
    rtcSetGeometryUserData(g, &groups_.back());
    rtcSetGeometryBoundsFunction(g, bound, nullptr);
    rtcSetGeometryIntersectFunction(g, intersect);
    return g;
  });
  boxes_.release();
}

void CellRays::refit(const mesh::MeshView& mesh, const core::Threads& threads) {
  set_boxes(mesh, threads);
  device_.reset_peak();
  scene_.refit(threads, [](RTCGeometry) {});
  boxes_.release();
}

/// The frame is fitted to the mesh each time, as the tree's is.
void CellRays::set_boxes(const mesh::MeshView& mesh, const core::Threads& threads) {
  mesh_ = &mesh;
  const Owners owners(mesh, threads);
  origin_ = owners.origin();
  cells_.resize_discard(std::size_t(owners.count()));
  boxes_.resize_discard(std::size_t(owners.count()));
  peak_boxes_ = std::int64_t(boxes_.bytes());
  owners.for_boxes(threads, nullptr,
                   [&](std::int64_t, std::int64_t rank, const std::uint32_t* ids, const Box* boxes,
                       std::uint32_t n) {
                     std::copy_n(ids, n, cells_.data() + rank);
                     std::copy_n(boxes, n, boxes_.data() + rank);
                   });
}

void CellRays::bound(const RTCBoundsFunctionArguments* args) {
  const Group& group = *static_cast<const Group*>(args->geometryUserPtr);
  const Box& box = group.rays->boxes_[group.first + args->primID];
  RTCBounds& out = *args->bounds_o;
  out.lower_x = box.lower[0];
  out.lower_y = box.lower[1];
  out.lower_z = box.lower[2];
  out.upper_x = box.upper[0];
  out.upper_y = box.upper[1];
  out.upper_z = box.upper[2];
}

/// A cell that holds the point strictly inside ends the search. Of cells that have it on their
/// boundary the lowest is kept, so that the order of the visits does not show.
void CellRays::intersect(const RTCIntersectFunctionNArguments* args) {
  const Group& group = *static_cast<const Group*>(args->geometryUserPtr);
  const CellRays& rays = *group.rays;
  const std::int64_t flat = rays.cells_[group.first + args->primID];
  if (args->valid[0] == 0 || (search.cell >= 0 && flat > search.cell))
    return;
  mesh::CellVertices cell;
  mesh::gather(*rays.mesh_, flat, cell);
  const cells::Containment where = cells::contain_exact(cell.shape, cell.x, search.point).where;
  if (where == cells::Containment::outside)
    return;
  search.cell = flat;
  if (where == cells::Containment::inside)
    RTCRayN_tfar(RTCRayHitN_RayN(args->rayhit, args->N), args->N, 0) = -1.0f; // nothing is left
}

void CellRays::find(std::span<const Vec3d> points, std::span<std::int64_t> cells,
                    std::span<std::int64_t> beyond) const {
  std::fill(beyond.begin(), beyond.end(), -1);
  for (std::size_t i = 0; i < points.size(); ++i) {
    search = {points[i], -1};
    trace(scene_, point_ray(points[i], origin_, 0x1p-120f));
    cells[i] = search.cell;
  }
}

RayLocatorReport CellRays::report() const {
  const auto held = std::int64_t(cells_.bytes());
  return {std::int64_t(cells_.size()), scene_.groups(), held + device_.bytes(),
          held + peak_boxes_ + device_.peak_bytes()};
}

} // namespace insitu::accel::embree

#include "accel/embree/grouped_scene.h"

#include <algorithm>
#include <cmath>

namespace insitu::accel::embree {

void GroupedScene::build(std::int64_t n, std::int64_t group, const core::Threads& threads,
                         Make make) {
  clear();
  group_ = group;
  scene_ = rtcNewScene(device_.handle());
  device_.check("making a scene");
  // To Embree, low quality means a hierarchy for each geometry, which REFIT builds by surface area;
  // only a dynamic scene keeps what it takes to refit them.
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_DYNAMIC);
  rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_LOW);
  for (std::int64_t begin = 0; begin < n; begin += group) {
    RTCGeometry geometry = make(begin, std::min(n, begin + group));
    rtcSetGeometryBuildQuality(geometry, RTC_BUILD_QUALITY_REFIT);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene_, geometry, unsigned(geometries_.size()));
    rtcReleaseGeometry(geometry);
    geometries_.push_back(geometry);
  }
  commit(threads, "building for rays");
}

void GroupedScene::refit(const core::Threads& threads,
                         core::FunctionRef<void(RTCGeometry)> changed) {
  for (RTCGeometry geometry : geometries_) {
    changed(geometry);
    rtcCommitGeometry(geometry);
  }
  commit(threads, "refitting for rays");
}

/// Joined, so that Embree's tasks keep the session's limit on threads.
void GroupedScene::commit(const core::Threads& threads, const char* what) {
  threads.run([&] { rtcJoinCommitScene(scene_); });
  device_.check(what);
}

void GroupedScene::clear() {
  geometries_.clear();
  if (scene_)
    rtcReleaseScene(scene_);
  scene_ = nullptr;
}

RTCHit trace(const GroupedScene& scene, const PointRay& ray) {
  RTCRayHit r;
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
  const math::Vec3f& o = ray.origin;
  constexpr float farthest = 3e37f;
  if (!(std::fabs(o.x) <= farthest && std::fabs(o.y) <= farthest && std::fabs(o.z) <= farthest))
    return r.hit;
  r.ray = {};
  r.ray.org_x = o.x;
  r.ray.org_y = o.y;
  r.ray.org_z = o.z;
  r.ray.dir_x = ray.direction.x;
  r.ray.dir_y = ray.direction.y;
  r.ray.dir_z = ray.direction.z;
  r.ray.tfar = ray.length;
  r.ray.mask = ~0u;
  intersect(scene.handle(), r);
  return r.hit;
}

} // namespace insitu::accel::embree

// What packets gain for rays from points: nanoseconds a ray of shared faces, by rtcIntersect1, 4, 8
// and 16 and rtcOccluded1 and 16, points in random order and sorted along a curve.
//   ray_packets_bench [cells (1000000)] [points (200000)]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "core/timer.h"
#include "face_scene.h"
#include "workload/queries.h"

#if RTC_VERSION_MAJOR < 4

namespace insitu {
namespace {

using math::Vec3d;

/// Structures of N rays, as Embree's packets are.
template <class Hits, int N, auto Trace>
double time_packets(const test::FaceScene& scene, const std::vector<Vec3d>& points,
                    std::int64_t& found) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  alignas(64) std::int32_t valid[N];
  std::fill_n(valid, N, -1);
  double least = 1e30;
  for (int repetition = 0; repetition < 5; ++repetition) {
    found = 0;
    const core::Timer timer;
    for (std::size_t i = 0; i + N <= points.size(); i += N) {
      Hits r;
      std::memset(static_cast<void*>(&r), 0, sizeof r);
      for (int k = 0; k < N; ++k) {
        const accel::PointRay ray = scene.ray(points[i + std::size_t(k)]);
        r.ray.org_x[k] = ray.origin.x;
        r.ray.org_y[k] = ray.origin.y;
        r.ray.org_z[k] = ray.origin.z;
        r.ray.dir_x[k] = ray.direction.x;
        r.ray.dir_y[k] = ray.direction.y;
        r.ray.dir_z[k] = ray.direction.z;
        r.ray.tfar[k] = ray.length;
        r.ray.mask[k] = ~0u;
        r.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        r.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
      }
      Trace(valid, scene.handle(), &context, r);
      for (int k = 0; k < N; ++k)
        found += r.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID || r.ray.tfar[k] < 0.0f;
    }
    least = std::min(least, 1e9 * timer.seconds() / double(points.size()));
  }
  return least;
}

struct One { // rtcIntersect1's ray, by the names of a packet
  struct {
    float org_x[1], org_y[1], org_z[1], tnear[1], dir_x[1], dir_y[1], dir_z[1], time[1], tfar[1];
    unsigned mask[1], id[1], flags[1];
  } ray;
  struct {
    float Ng_x[1], Ng_y[1], Ng_z[1], u[1], v[1];
    unsigned primID[1], geomID[1], instID[1][1];
  } hit;
};

void measure(const test::FaceScene& scene, const std::vector<Vec3d>& points, const char* order) {
  std::int64_t found = 0;
  const auto print = [&](const char* call, double ns) {
    std::printf("%-8s %-14s %7.0f ns a ray, %lld of %zu hit\n", order, call, ns,
                static_cast<long long>(found), points.size());
  };
  print("rtcIntersect1", time_packets<One, 1, [](int*, RTCScene s, auto* c, One& r) {
          alignas(16) RTCRayHit one;
          static_assert(sizeof one.ray == sizeof r.ray);
          std::memcpy(&one.ray, &r.ray, sizeof r.ray);
          one.hit.geomID = RTC_INVALID_GEOMETRY_ID;
          one.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
          rtcIntersect1(s, c, &one);
          r.hit.geomID[0] = one.hit.geomID;
        }>(scene, points, found));
  print("rtcIntersect4", time_packets<RTCRayHit4, 4, [](int* v, RTCScene s, auto* c, auto& r) {
          rtcIntersect4(v, s, c, &r);
        }>(scene, points, found));
  print("rtcIntersect8", time_packets<RTCRayHit8, 8, [](int* v, RTCScene s, auto* c, auto& r) {
          rtcIntersect8(v, s, c, &r);
        }>(scene, points, found));
  print("rtcIntersect16", time_packets<RTCRayHit16, 16, [](int* v, RTCScene s, auto* c, auto& r) {
          rtcIntersect16(v, s, c, &r);
        }>(scene, points, found));
  print("rtcOccluded1", time_packets<One, 1, [](int*, RTCScene s, auto* c, One& r) {
          alignas(16) RTCRay one;
          std::memcpy(&one, &r.ray, sizeof r.ray);
          rtcOccluded1(s, c, &one);
          r.ray.tfar[0] = one.tfar;
        }>(scene, points, found));
  print("rtcOccluded16", time_packets<RTCRayHit16, 16, [](int* v, RTCScene s, auto* c, auto& r) {
          rtcOccluded16(v, s, c, &r.ray);
        }>(scene, points, found));
}

} // namespace
} // namespace insitu

int main(int count, char** arguments) {
  using namespace insitu;
  const auto number = [&](int i, std::int64_t otherwise) {
    return count > i ? std::int64_t(std::atoll(arguments[i])) : otherwise;
  };
  test::FaceScene scene(accel::Method::shared_faces, number(1, 1'000'000), false);
  auto points =
      workload::make_queries(scene.box(), workload::Pattern::random, number(2, 200'000)).points;
  measure(scene, points, "random");
  std::sort(points.begin(), points.end(), [](const math::Vec3d& a, const math::Vec3d& b) {
    const auto code = [](const math::Vec3d& p) {
      std::uint64_t out = 0;
      for (int bit = 9; bit >= 0; --bit)
        for (int axis = 0; axis < 3; ++axis)
          out = out << 1 | (std::uint64_t(p[axis] * 1023.0) >> bit & 1);
      return out;
    };
    return code(a) < code(b);
  });
  measure(scene, points, "sorted");
}

#else
int main() {
  std::puts("built with Embree 4: packets are measured with Embree 3");
}
#endif

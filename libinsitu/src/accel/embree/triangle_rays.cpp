#include "accel/camera_rays/triangle_rays.h"

#include <algorithm>
#include <cmath>

#include "accel/embree/device.h"
#include "core/status.h"

namespace insitu::accel {

using math::Vec3d;

/// Embree has the coordinates in float, from the bounds' middle and in units of about their size:
/// so neither an offset nor a scale costs digits, and rays begin at the bounds however far the
/// viewer is.
struct TriangleRays::Scene {
  explicit Scene(core::Memory& memory) : device(memory), vertices(memory, INSITU_MEMORY_FRAME) {}
  ~Scene() {
    if (handle)
      rtcReleaseScene(handle);
  }

  embree::Device device;
  RTCScene handle = nullptr;
  core::Buffer<float> vertices;
  std::span<const Vec3d> points;
  std::span<const Ids> triangles;
  Vec3d low, high, middle;
  double unit = 1, extent = 0;
};

namespace {

/// In units of the scene; what float may lose of a place.
constexpr double slack = 1e-5;

struct Context {
#if RTC_VERSION_MAJOR >= 4
  RTCRayQueryContext embree;
#else
  RTCIntersectContext embree;
#endif
  std::span<const Vec3d> points;
  std::span<const TriangleRays::Ids> triangles;
  Vec3d origin, direction;
  double t_min, t_max;
  double from, unit; ///< of Embree's distances
  core::FunctionRef<bool(const TriangleHit&)>* met;
};

void filter(const RTCFilterFunctionNArguments* args) {
  if (args->valid[0] == 0)
    return;
  args->valid[0] = 0; // goes on, unless told otherwise
  const auto& c = *reinterpret_cast<const Context*>(args->context);
  TriangleHit hit;
  hit.triangle = RTCHitN_primID(args->hit, args->N, 0);
  hit.u = double(RTCHitN_u(args->hit, args->N, 0));
  hit.v = double(RTCHitN_v(args->hit, args->N, 0));
  hit.t = c.from + c.unit * double(RTCRayN_tfar(args->ray, args->N, 0));
  const TriangleRays::Ids& ids = c.triangles[hit.triangle];
  const Vec3d a = c.points[ids[0]];
  const Vec3d n = cross(c.points[ids[1]] - a, c.points[ids[2]] - a);
  const double t = dot(n, a - c.origin) / dot(n, c.direction);
  if (std::fabs(t - hit.t) <= slack * c.unit) // else it is seen edge-on
    hit.t = t;
  if (hit.t >= c.t_min && hit.t <= c.t_max && (*c.met)(hit))
    args->valid[0] = -1;
}

} // namespace

TriangleRays::TriangleRays(std::span<const Vec3d> points, std::span<const Ids> triangles,
                           const mesh::Box* bounds, const core::Threads& threads,
                           core::Memory& memory)
    : scene_(std::make_unique<Scene>(memory)) {
  Scene& s = *scene_;
  s.points = points;
  s.triangles = triangles;
  if (triangles.empty())
    return;
  s.low = bounds ? bounds->low : points[triangles[0][0]];
  s.high = bounds ? bounds->high : s.low;
  for (const Ids& ids : triangles)
    for (const std::uint32_t id : ids)
      for (int a = 0; a < 3; ++a) {
        s.low[a] = std::min(s.low[a], points[id][a]);
        s.high[a] = std::max(s.high[a], points[id][a]);
      }
  s.middle = 0.5 * (s.low + s.high);
  const Vec3d d = s.high - s.low;
  s.extent = std::sqrt(dot(d, d));
  s.unit = s.extent > 0 ? std::exp2(std::ceil(std::log2(s.extent))) : 1.0;
  s.vertices.resize_discard(3 * points.size() + 1); // Embree reads 16 bytes a vertex
  s.vertices[3 * points.size()] = 0;
  threads.parallel_for(
      std::int64_t(points.size()), 4096, [&](std::int64_t begin, std::int64_t end) {
        for (auto v = std::size_t(begin); v < std::size_t(end); ++v)
          for (int a = 0; a < 3; ++a)
            s.vertices[3 * v + std::size_t(a)] = float((points[v][a] - s.middle[a]) / s.unit);
      });
  s.handle = rtcNewScene(s.device.handle());
  s.device.check("making a scene");
  rtcSetSceneFlags(s.handle, RTC_SCENE_FLAG_ROBUST);
  RTCGeometry g = rtcNewGeometry(s.device.handle(), RTC_GEOMETRY_TYPE_TRIANGLE);
  rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, s.vertices.data(), 0,
                             3 * sizeof(float), points.size());
  rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, triangles.data(), 0,
                             sizeof(Ids), triangles.size());
  rtcSetGeometryIntersectFilterFunction(g, filter);
  rtcCommitGeometry(g);
  rtcAttachGeometry(s.handle, g);
  rtcReleaseGeometry(g);
  // Joined, so that Embree's tasks keep the session's limit on threads.
  threads.run([&] { rtcJoinCommitScene(s.handle); });
  s.device.check("building triangles for rays");
}

TriangleRays::~TriangleRays() = default;

double TriangleRays::extent() const {
  return scene_->extent;
}

std::int64_t TriangleRays::bytes() const {
  return std::int64_t(scene_->vertices.bytes()) + scene_->device.bytes();
}

void TriangleRays::meet(const Vec3d& origin, const Vec3d& direction, double t_min, double t_max,
                        core::FunctionRef<bool(const TriangleHit&)> met) const {
  const Scene& s = *scene_;
  if (!s.handle)
    return;
  const double around = slack * s.unit;
  double near = t_min, far = t_max;
  for (int a = 0; a < 3; ++a) {
    const double to_low = s.low[a] - around - origin[a], to_high = s.high[a] + around - origin[a];
    if (direction[a] == 0) {
      if (to_low > 0 || to_high < 0)
        return;
      continue;
    }
    near = std::max(near, (direction[a] > 0 ? to_low : to_high) / direction[a]);
    far = std::min(far, (direction[a] > 0 ? to_high : to_low) / direction[a]);
  }
  if (!(near <= far))
    return;
  Context context;
#if RTC_VERSION_MAJOR >= 4
  rtcInitRayQueryContext(&context.embree);
#else
  rtcInitIntersectContext(&context.embree);
#endif
  context.points = s.points;
  context.triangles = s.triangles;
  context.origin = origin;
  context.direction = direction;
  context.t_min = t_min;
  context.t_max = t_max;
  context.from = near - around;
  context.unit = s.unit;
  context.met = &met;
  const Vec3d start = (origin + context.from * direction - s.middle) / s.unit;
  RTCRayHit r = {};
  r.ray.org_x = float(start.x);
  r.ray.org_y = float(start.y);
  r.ray.org_z = float(start.z);
  r.ray.dir_x = float(direction.x);
  r.ray.dir_y = float(direction.y);
  r.ray.dir_z = float(direction.z);
  r.ray.tfar = float((far - context.from) / s.unit + slack);
  r.ray.mask = ~0u;
  r.hit.geomID = RTC_INVALID_GEOMETRY_ID;
  r.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.context = &context.embree;
  rtcIntersect1(s.handle, &r, &arguments);
#else
  rtcIntersect1(s.handle, &context.embree, &r);
#endif
}

} // namespace insitu::accel

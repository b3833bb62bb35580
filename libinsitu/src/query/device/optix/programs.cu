// The device programs of the ray methods (Morrical 2020, sections 5 to 7), compiled to OptiX-IR.
// What they decide is in accel/rays/ and query/device/fast_cell.h; these bring the ray, the hit and
// the outputs. method, ask and shape are known when the driver compiles a module, so the branches
// on them are gone.
#include <optix.h>

#include "accel/locator.h"
#include "accel/rays/ray_rules.h"
#include "query/device/answer.cuh"
#include "query/device/fast_map.cuh"
#include "query/device/optix/launch.h"

using namespace insitu;
using namespace insitu::accel;
using namespace insitu::query;
using math::Vec3d;
using math::Vec3f;
using mesh::Shape;
using query::optix::Ask;

static_assert(sizeof(query::optix::Launch) % sizeof(std::uint64_t) == 0);
extern "C" {
/// An query::optix::Launch; as numbers, since its views have initialisers.
__constant__ std::uint64_t launch_parameters[sizeof(query::optix::Launch) / sizeof(std::uint64_t)];
}
#define launch (reinterpret_cast<const query::optix::Launch&>(launch_parameters))

namespace {

__device__ inline Method method() {
  return Method(launch.method);
}
__device__ inline Ask ask() {
  return Ask(launch.ask);
}

/// The flags of a method's rays. Nothing has an any-hit program.
__device__ inline unsigned ray_flags() {
  switch (method()) {
  case Method::user_geometry: // the intersection program has told all
    return OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_DISABLE_CLOSESTHIT |
           OPTIX_RAY_FLAG_TERMINATE_ON_FIRST_HIT;
  case Method::replicated_faces:
    return OPTIX_RAY_FLAG_DISABLE_ANYHIT | OPTIX_RAY_FLAG_CULL_BACK_FACING_TRIANGLES;
  default:
    return OPTIX_RAY_FLAG_DISABLE_ANYHIT;
  }
}

__device__ inline bool shares_faces() {
  return method() == Method::shared_faces || method() == Method::shared_bilinear_faces;
}

/// Writes what was asked for but interpolated values.
__device__ inline void write_cell(unsigned i, std::uint32_t flat, const device::CellPlace& at) {
  if (launch.candidates)
    launch.candidates[i] = flat;
  if (ask() == Ask::candidates)
    return;
  on_device::write_owner(launch.query.out, i, flat, cells::Reason::certified);
  if (ask() == Ask::cell_values)
    on_device::write_cell_values(launch.query.out, i, at);
}

/// Writes what was asked for of a point in a cell; with `test`, only if floats put it there.
template <Shape S>
__device__ inline bool answer(unsigned i, std::uint32_t flat, const Vec3d& p, bool test) {
  const device::CellPlace at = device::place_of<S>(launch.query.in.mesh, flat);
  if (!test && ask() != Ask::interpolated) {
    write_cell(i, flat, at);
    return true;
  }
  return device::for_shape<S>(at, [&]<Shape Of>() {
    const device::Gathered<Of> cell(at);
    const on_device::FastMap map = on_device::fast_map(cell, p);
    if (test && !(map.margin >= on_device::fast_margin))
      return false;
    if (ask() == Ask::interpolated)
      on_device::write_answer(launch.query.out, i, flat, at, cell, cells::Reason::certified,
                              {double(map.r.x), double(map.r.y), double(map.r.z)});
    else
      write_cell(i, flat, at);
    return true;
  });
}

__device__ inline bool answer(unsigned i, std::uint32_t flat, const Vec3d& p, bool test) {
  switch (Shape(launch.shape)) {
  case Shape::tetrahedron:
    return answer<Shape::tetrahedron>(i, flat, p, test);
  case Shape::hexahedron:
    return answer<Shape::hexahedron>(i, flat, p, test);
  default:
    return answer<Shape::none>(i, flat, p, test);
  }
}

__device__ inline void write_nothing(unsigned i) {
  if (launch.candidates)
    launch.candidates[i] = none;
  if (ask() != Ask::candidates)
    on_device::write_outside(launch.query.out, i);
}

/// The cell on the side of the face that the ray has hit, or `none`.
__device__ inline std::uint32_t cell_of(const FaceTriangle& triangle, bool back,
                                        const PointRay& ray) {
  if (method() == Method::shared_faces)
    return back ? triangle.back : triangle.front;
  return cell_of_hit(triangle, back, [&](const FaceTriangle& t) {
    // The ray's own vertices, so that the tetrahedron is the one that it hit.
    const std::uint32_t ids[4] = {t.vertices[0], t.vertices[1], t.vertices[2], t.corner};
    Vec3d quad[4];
    for (int k = 0; k < 4; ++k) {
      const Vec3f& x = launch.vertices[ids[k]];
      quad[k] = {x.x, x.y, x.z};
    }
    return is_beside(quad, Vec3d{ray.origin.x, ray.origin.y, ray.origin.z});
  });
}

/// Whether floats can trace the ray; NaN, infinite and distant points have none.
__device__ inline bool can_start(const PointRay& ray) {
  constexpr float farthest = 1e37f;
  const Vec3f& o = ray.origin;
  return fabsf(o.x) < farthest && fabsf(o.y) < farthest && fabsf(o.z) < farthest;
}

} // namespace

extern "C" __global__ void __raygen__query() {
  const unsigned i = optixGetLaunchIndex().x;
  const Vec3d p = on_device::point_of(launch.query, i);
  const PointRay ray = point_ray(p, launch.origin, launch.length);
  unsigned found = none;
  if (can_start(ray))
    optixTrace(launch.tree, float3{ray.origin.x, ray.origin.y, ray.origin.z},
               float3{ray.direction.x, ray.direction.y, ray.direction.z}, 0.0f, ray.length, 0.0f,
               OptixVisibilityMask(255), ray_flags(), 0, 1, 0, found);
  if (found == none) {
    if (ask() == Ask::candidates && launch.others)
      launch.others[i] = none;
    return write_nothing(i);
  }
  if (method() == Method::user_geometry)
    return; // the intersection program has written
  if (shares_faces()) {
    const FaceTriangle& triangle = launch.triangles[found & ~query::optix::hit_back];
    found = cell_of(triangle, found & query::optix::hit_back, ray);
    if (ask() == Ask::candidates)
      launch.others[i] = found == triangle.front ? triangle.back : triangle.front;
    if (found == none)
      return write_nothing(i);
  }
  // Behind culled faces lies what is outside: one test of the point in the cell. Who verifies
  // candidates does it anyway.
  const bool test = method() == Method::replicated_faces && ask() != Ask::candidates;
  if (!answer(i, found, p, test))
    write_nothing(i);
}

/// The face methods: what was hit. The ray generation program does the rest, so that no more than
/// this goes through the traversal.
extern "C" __global__ void __closesthit__face() {
  const unsigned primitive = optixGetPrimitiveIndex();
  if (shares_faces())
    optixSetPayload_0(optixIsTriangleBackFaceHit() ? primitive | query::optix::hit_back
                                                   : primitive);
  else
    optixSetPayload_0(launch.triangles[primitive].front);
}

/// user_geometry: whether the cell holds the point; the first that does ends the ray.
extern "C" __global__ void __intersection__cell() {
  const std::uint32_t flat = launch.owners[optixGetPrimitiveIndex()];
  const unsigned i = optixGetLaunchIndex().x;
  if (!answer(i, flat, on_device::point_of(launch.query, i), true))
    return;
  optixSetPayload_0(flat);
  optixReportIntersection(optixGetRayTmin(), 0);
}

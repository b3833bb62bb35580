// The device programs of the ray methods (Morrical 2020, sections 5 to 7), compiled to OptiX-IR.
// What they decide is in accel/rays/ and cells/; these bring the ray, the hit and the outputs.
// method and ask are known when the driver compiles a module, so the branches on them are gone.
#include <optix.h>

#include "accel/locator.h"
#include "accel/optix/launch.h"
#include "accel/rays/ray_answer.h"
#include "accel/rays/ray_rules.h"

using namespace insitu;
using namespace insitu::accel;
using optix::Ask;

static_assert(sizeof(optix::Launch) % sizeof(std::uint64_t) == 0);
extern "C" {
/// An optix::Launch; as numbers, since its views have initialisers.
__constant__ std::uint64_t launch_parameters[sizeof(optix::Launch) / sizeof(std::uint64_t)];
}
#define launch (reinterpret_cast<const optix::Launch&>(launch_parameters))

namespace {

__device__ inline Method method() {
  return Method(launch.method);
}
__device__ inline Ask ask() {
  return Ask(launch.ask);
}

__device__ inline math::Vec3d query_point(unsigned i) {
  const double* p = launch.points + 3 * std::size_t(i);
  return {p[0], p[1], p[2]};
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

/// Writes what was asked for of a point in a cell. x, r: the cell gathered and the point's
/// coordinates in it, where they are known.
__device__ inline void write_inside(unsigned i, std::uint32_t cell, const mesh::CellVertices* x,
                                    const math::Vec3d& r) {
  if (launch.candidates)
    launch.candidates[i] = cell;
  if (launch.cells)
    launch.cells[i] = cell;
  if (launch.reasons)
    launch.reasons[i] = certified_reason;
  if (ask() == Ask::interpolated) {
    if (launch.parametric)
      for (int a = 0; a < 3; ++a)
        launch.parametric[3 * std::size_t(i) + a] = r[a];
    write_fields(*x, launch.mesh, cell, r, launch.fields, launch.field_count, launch.values, i);
  } else if (ask() == Ask::cell_values) {
    write_cell_fields(launch.mesh, cell, launch.fields, launch.field_count, launch.values, i);
  }
}

__device__ inline void write_outside(unsigned i) {
  if (launch.candidates)
    launch.candidates[i] = none;
  if (launch.cells)
    launch.cells[i] = -1;
  if (launch.reasons)
    launch.reasons[i] = outside_reason;
  if (ask() == Ask::interpolated && launch.parametric)
    for (int a = 0; a < 3; ++a)
      launch.parametric[3 * std::size_t(i) + a] = not_a_number();
  if (ask() == Ask::interpolated || ask() == Ask::cell_values)
    write_no_fields(launch.fields, launch.field_count, launch.values, i);
}

} // namespace

extern "C" __global__ void __raygen__query() {
  const unsigned i = optixGetLaunchIndex().x;
  const math::Vec3d p = query_point(i);
  const PointRay ray = point_ray(p, launch.origin, launch.length);
  unsigned cell = none;
  // No ray starts at a point that is not finite, or so far out that floats end.
  if (can_start(ray))
    optixTrace(launch.tree, float3{ray.origin.x, ray.origin.y, ray.origin.z},
               float3{ray.direction.x, ray.direction.y, ray.direction.z}, 0.0f, ray.length, 0.0f,
               OptixVisibilityMask(255), ray_flags(), 0, 1, 0, cell);
  if (ask() == Ask::candidates) {
    launch.candidates[i] = cell;
    return;
  }
  if (method() == Method::user_geometry) {
    if (cell == none) // else the intersection program has written
      write_outside(i);
    return;
  }
  if (cell == none) {
    write_outside(i);
    return;
  }
  // Behind culled faces lies what is outside: one test of the point in the cell.
  const bool test = method() == Method::replicated_faces;
  if (!test && ask() != Ask::interpolated) {
    write_inside(i, cell, nullptr, {});
    return;
  }
  mesh::CellVertices x;
  mesh::gather(launch.mesh, cell, x);
  const auto map = cells::inverse_map(x.shape, x.x, p);
  if (test && !holds(map))
    write_outside(i);
  else
    write_inside(i, cell, &x, parametric_of(map));
}

/// The face methods: the cell on the side of the face that the ray has hit.
extern "C" __global__ void __closesthit__face() {
  const FaceTriangle& triangle = launch.triangles[optixGetPrimitiveIndex()];
  if (method() == Method::replicated_faces) {
    optixSetPayload_0(triangle.front);
    return;
  }
  const std::uint32_t cell =
      cell_of_hit(triangle, optixIsTriangleBackFaceHit(), [](const FaceTriangle& t) {
        // The ray's own vertices, so that the tetrahedron is the one that it hit.
        const std::uint32_t ids[4] = {t.vertices[0], t.vertices[1], t.vertices[2], t.corner};
        math::Vec3d quad[4];
        for (int k = 0; k < 4; ++k) {
          const math::Vec3f& x = launch.vertices[ids[k]];
          quad[k] = {x.x, x.y, x.z};
        }
        const float3 p = optixGetWorldRayOrigin();
        return is_beside(quad, math::Vec3d{p.x, p.y, p.z});
      });
  optixSetPayload_0(cell);
}

/// user_geometry: whether the cell holds the point; the first that does ends the ray.
extern "C" __global__ void __intersection__cell() {
  const unsigned primitive = optixGetPrimitiveIndex();
  const std::uint32_t cell = launch.owners ? launch.owners[primitive] : primitive;
  const unsigned i = optixGetLaunchIndex().x;
  mesh::CellVertices x;
  mesh::gather(launch.mesh, cell, x);
  const auto map = cells::inverse_map(x.shape, x.x, query_point(i));
  if (!holds(map))
    return;
  if (ask() != Ask::candidates)
    write_inside(i, cell, &x, parametric_of(map));
  optixSetPayload_0(cell);
  optixReportIntersection(optixGetRayTmin(), 0);
}

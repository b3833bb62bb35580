// Queries of meshes whose locator runs on a device.
#include <algorithm>

#include "advect/device/device_tracer.h"
#include "api/session.h"
#include "core/caller_struct.h"
#include "core/timer.h"
#include "query/device/device_locator.h"
#include "scene/earth/reference_frames.h"

namespace insitu::api {

using core::Error;

namespace {

template <class T>
T* from(T* array, std::int64_t first, int components = 1) {
  return array ? array + first * components : nullptr;
}

/// What is asked, answers written from item `first` on.
query::DeviceQuery query_of(const insitu_locate_args& args, std::int64_t first) {
  query::DeviceQuery q;
  q.accuracy = args.accuracy;
  q.cells = from(args.cells, first);
  q.by_piece = true;
  q.cell_base = args.cell_base;
  q.pieces = from(args.pieces, first);
  q.found = from(args.found, first);
  q.parametric = from(args.parametric, first, 3);
  q.reasons = from(args.reasons, first);
  return q;
}

[[noreturn]] void refuse(const std::string& what) {
  throw Error(INSITU_ERROR_UNSUPPORTED, what);
}

} // namespace

/// Points and answers stay on the device; only points it has to settle come to the host.
void Session::answer_in_device_memory(const commit::CommittedMesh& mesh,
                                      const insitu_locate_args& args, const QueryPoints& points,
                                      std::span<const mesh::FieldView> fields,
                                      double* const* values) {
  if (!mesh.device())
    refuse("memory: device memory needs a locator on a device; insitu_mesh_locator and a commit "
           "make one");
  if (args.frame)
    refuse("frame: points in device memory are taken in the mesh's frame");
  const math::Vec3d* const in_place = points.in_place();
  if (!in_place)
    refuse("points: in device memory one packed array of float64 with 3 components expected");
  query::DeviceQuery q = query_of(args, 0);
  q.points = &in_place->x;
  q.count = points.count();
  q.on_device = true;
  q.stream = args.stream;
  q.fields = fields;
  q.values = values;
  mesh.note(mesh.device()->locate(q));
  statistics_.points_located += q.count;
}

/// Points and answers on the host.
void Session::answer_by_device(const commit::CommittedMesh& mesh, const insitu_locate_args& args,
                               const QueryPoints& points, std::span<const mesh::FieldView> fields,
                               double* const* values) {
  const std::int64_t n = points.count();
  std::vector<std::uint8_t> reasons;
  std::vector<double*> values_here(fields.size());
  for_each_slice(mesh, args, points, [&](std::int64_t first, std::span<const math::Vec3d> slice) {
    query::DeviceQuery q = query_of(args, first);
    q.points = &slice.data()->x;
    q.count = std::int64_t(slice.size());
    if (!q.reasons) { // they are counted
      reasons.resize(slice.size());
      q.reasons = reasons.data();
    }
    for (std::size_t f = 0; f < fields.size(); ++f)
      values_here[f] = from(values[f], first, fields[f].components);
    q.fields = fields;
    q.values = values_here.data();
    mesh.note(mesh.device()->locate(q), {q.reasons, slice.size()});
    statistics_.points_outside +=
        std::count(q.reasons, q.reasons + slice.size(), std::uint8_t(INSITU_REASON_OUTSIDE));
  });
  statistics_.points_located += n;
}

void Session::advance(SessionMesh& to, const insitu_advance_args& given) {
  const core::Timer timer;
  const insitu_advance_args args = core::from_caller(&given, "args");
  const commit::CommittedMesh& mesh = committed(to);
  if (!mesh.device())
    refuse(
        "advance: particles in device memory need a locator on a device; insitu_mesh_locator and "
        "a commit make one");
  const auto require = [](bool holds, const std::string& what) {
    if (!holds)
      throw Error(INSITU_ERROR_ARGUMENT, what);
  };
  require(args.velocity, "velocity: null");
  require(args.count >= 0 && args.steps >= 0, "count " + std::to_string(args.count) + ", steps " +
                                                  std::to_string(args.steps) +
                                                  ": 0 or more expected");
  require(args.step - args.step == 0.0, "step: not finite");
  require(args.count == 0 || (args.positions && args.cells && args.endings),
          "positions, cells or endings: null");
  const mesh::FieldView velocity = mesh.mesh().field(args.velocity);
  require(velocity.components == 3, std::string("velocity: field '") + args.velocity + "' has " +
                                        std::to_string(velocity.components) +
                                        " components, 3 expected");
  advect::DeviceTracer(*mesh.device())
      .advance({args.positions, args.cells, args.endings, args.count, velocity, args.step,
                args.steps, args.stream});
  statistics_.advect_s += timer.seconds();
}

} // namespace insitu::api

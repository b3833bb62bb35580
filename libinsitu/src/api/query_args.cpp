#include "api/query_args.h"

#include <limits>

#include "core/caller_struct.h"

namespace insitu::api {

using core::Error;

QueryPoints::QueryPoints(const insitu_locate_args& args) {
  core::check_argument(&args, "args");
  if (args.point_arrays == INSITU_LACKS_MEMORY)
    throw Error(INSITU_ERROR_MEMORY, "out of memory");
  if (!args.points || (args.point_arrays != 1 && args.point_arrays != 3))
    throw Error(INSITU_ERROR_ARGUMENT,
                !args.points
                    ? std::string("points: the array is null")
                    : "point_arrays: " + std::to_string(args.point_arrays) + ", 1 or 3 expected");
  if (args.accuracy < INSITU_FAST || args.accuracy > INSITU_EXACT)
    throw Error(INSITU_ERROR_ARGUMENT,
                "accuracy: unknown value " + std::to_string(int(args.accuracy)));
  if (args.cell_base != 0 && args.cell_base != 1)
    throw Error(INSITU_ERROR_ARGUMENT,
                "cell_base: " + std::to_string(args.cell_base) + ", 0 or 1 expected");
  if (args.memory != INSITU_HOST && args.memory != INSITU_DEVICE)
    throw Error(INSITU_ERROR_ARGUMENT, "memory: unknown value " + std::to_string(int(args.memory)));
  if (args.scope != INSITU_SCOPE_LOCAL && args.scope != INSITU_SCOPE_EVERYWHERE)
    throw Error(INSITU_ERROR_ARGUMENT, "scope: unknown value " + std::to_string(int(args.scope)));
  if (args.memory == INSITU_DEVICE &&
      (args.scope == INSITU_SCOPE_EVERYWHERE || args.ranks || args.global_cells))
    throw Error(INSITU_ERROR_UNSUPPORTED,
                "scope, ranks, global_cells: other processes' cells are asked on the host");
  if (args.outside != INSITU_OUTSIDE_NONE && args.outside != INSITU_OUTSIDE_NEAREST)
    throw Error(INSITU_ERROR_ARGUMENT,
                "outside: unknown value " + std::to_string(int(args.outside)));
  require_distance(args.greatest_distance);
  if (args.outside == INSITU_OUTSIDE_NONE && (args.distances || args.nearest))
    throw Error(INSITU_ERROR_ARGUMENT, std::string(args.distances ? "distances" : "nearest") +
                                           ": asked for without INSITU_OUTSIDE_NEAREST");
  if (args.outside == INSITU_OUTSIDE_NEAREST && args.memory == INSITU_DEVICE)
    throw Error(INSITU_ERROR_UNSUPPORTED, "outside: nearest cells are found on the host");
  for (int i = 0; i < args.point_arrays; ++i) {
    if (args.points[i].memory != args.memory)
      throw Error(INSITU_ERROR_ARGUMENT,
                  std::string("points lie in ") +
                      (args.points[i].memory == INSITU_DEVICE ? "device" : "host") +
                      " memory, the answers (memory) in the other; both in one expected");
    arrays_.push_back(mesh::adopt(args.points + i, "points"));
    const mesh::ExternalArray& a = arrays_.back();
    mesh::require_real(a, "points");
    if (a.components != (args.point_arrays == 1 ? 3 : 1) ||
        a.layout.count != arrays_.front().layout.count)
      throw Error(INSITU_ERROR_ARGUMENT,
                  "points, array " + std::to_string(i) + ": " + std::to_string(a.components) +
                      " components of " + std::to_string(a.layout.count) +
                      " items; one array of 3 components or 3 equal ones of 1 expected");
  }
}

const math::Vec3d* QueryPoints::in_place() const {
  const mesh::ExternalArray& a = arrays_.front();
  const bool same = arrays_.size() == 1 && a.type == INSITU_FLOAT64 &&
                    a.component_stride == sizeof(double) && a.layout.linear &&
                    a.layout.stride[0] == sizeof(math::Vec3d) &&
                    reinterpret_cast<std::uintptr_t>(a.data) % alignof(math::Vec3d) == 0;
  return same ? reinterpret_cast<const math::Vec3d*>(a.data) : nullptr;
}

void QueryPoints::gather(std::int64_t first, std::span<math::Vec3d> out,
                         const core::Threads& threads) const {
  constexpr std::int64_t grain = 4096;
  const bool interleaved = arrays_.size() == 1;
  threads.parallel_for(std::int64_t(out.size()), grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      for (int c = 0; c < 3; ++c) {
        const mesh::ExternalArray& a = arrays_[interleaved ? 0 : std::size_t(c)];
        const std::byte* p =
            a.data + a.layout.offset(first + i) + (interleaved ? c * a.component_stride : 0);
        out[std::size_t(i)][c] = mesh::load_real(p, a.type == INSITU_FLOAT32);
      }
  });
}

void require_distance(double greatest_distance) {
  if (!(greatest_distance >= 0.0))
    throw Error(INSITU_ERROR_ARGUMENT,
                "greatest_distance: " + std::to_string(greatest_distance) + ", 0 or more expected");
}

double farthest_of(double greatest_distance) {
  return greatest_distance > 0.0 ? greatest_distance : std::numeric_limits<double>::infinity();
}

void require_field_lists(const insitu_sample_args& args) {
  if (args.field_count < 0 || (args.field_count > 0 && (!args.fields || !args.values)))
    throw Error(INSITU_ERROR_ARGUMENT, "field_count is " + std::to_string(args.field_count) +
                                           (args.fields ? "" : ", fields is null") +
                                           (args.values ? "" : ", values is null"));
}

QueryOutputs::QueryOutputs(const insitu_locate_args& args, std::int64_t count) {
  add(args.cells, count * std::int64_t(sizeof *args.cells), "cells");
  add(args.pieces, count * std::int64_t(sizeof *args.pieces), "pieces");
  add(args.parametric, count * 3 * std::int64_t(sizeof *args.parametric), "parametric");
  add(args.found, count, "found");
  add(args.reasons, count, "reasons");
  add(args.ranks, count * std::int64_t(sizeof *args.ranks), "ranks");
  add(args.global_cells, count * std::int64_t(sizeof *args.global_cells), "global_cells");
  add(args.distances, count * std::int64_t(sizeof *args.distances), "distances");
  add(args.nearest, count * 3 * std::int64_t(sizeof *args.nearest), "nearest");
}

void QueryOutputs::add(const void* data, std::int64_t bytes, std::string name) {
  if (!data || bytes == 0)
    return;
  const auto begin = reinterpret_cast<std::uintptr_t>(data);
  outputs_.push_back({{begin, begin + std::uintptr_t(bytes)}, std::move(name)});
}

void QueryOutputs::refuse_overlaps(const QueryPoints& points, const mesh::Mesh& mesh,
                                   std::span<const char* const> fields) const {
  const auto refuse = [](const std::string& a, const std::string& b) {
    throw Error(INSITU_ERROR_ARGUMENT, a + " overlaps " + b);
  };
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    const Output& out = outputs_[i];
    for (std::size_t k = 0; k < i; ++k)
      if (out.range.meets(outputs_[k].range))
        refuse(out.name, outputs_[k].name);
    for (std::size_t k = 0; k < points.arrays().size(); ++k)
      if (out.range.meets(points.arrays()[k].range()))
        refuse(out.name, points.arrays().size() == 1 ? std::string("the points")
                                                     : "the points, array " + std::to_string(k));
  }
  using Kind = mesh::Mesh::ArrayKind;
  const auto check = [&](const mesh::ExternalArray& array, const std::string& name, Kind) {
    const mesh::ExternalArray::Range range = array.range();
    // Between the items of a strided array there may be room that is meant for answers.
    if (range.end - range.begin > std::uintptr_t(array.bytes()))
      return;
    for (const Output& out : outputs_)
      if (out.range.meets(range))
        refuse(out.name, "the array '" + name + "' of mesh '" + mesh.name() + "'");
  };
  mesh.visit_arrays([&](const mesh::ExternalArray& array, const std::string& name, Kind kind) {
    if (kind != Kind::field) // answers may become a field of the mesh
      check(array, name, kind);
  });
  for (const char* const field : fields)
    mesh.visit_field_arrays(field, check);
}

} // namespace insitu::api

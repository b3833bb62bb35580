#include <algorithm>
#include <limits>

#include "api/session.h"
#include "core/status.h"
#include "core/timer.h"
#include "geo/frames.h"
#include "mesh/external_array.h"
#include "scene/frames.h"

namespace insitu::api {

using core::Error;

namespace {

constexpr std::int64_t grain = 4096;

/// The points' bytes [first, last], to tell an output that overlaps them.
bool overlaps(const mesh::ExternalArray& array, const void* output, std::int64_t bytes) {
  if (!output || array.layout.count == 0)
    return false;
  std::int64_t low = 0, high = 0;
  const std::int64_t last[3] = {
      array.layout.linear ? array.layout.count - 1 : array.layout.extent[0] - 1,
      array.layout.linear ? 0 : array.layout.extent[1] - 1,
      array.layout.linear
          ? 0
          : array.layout.count / (array.layout.extent[0] * array.layout.extent[1]) - 1};
  for (int a = 0; a < 3; ++a) {
    const std::int64_t span = last[a] * array.layout.stride[a];
    (span < 0 ? low : high) += span;
  }
  const std::int64_t components = (array.components - 1) * array.component_stride;
  (components < 0 ? low : high) += components;
  const std::byte* begin = array.data + low;
  const std::byte* end = array.data + high + mesh::size_of(array.type);
  const auto* out = static_cast<const std::byte*>(output);
  return out < end && begin < out + bytes;
}

/// The points of a query, gathered as doubles.
struct QueryPoints {
  std::vector<math::Vec3d> points;
  std::vector<mesh::ExternalArray> arrays;

  void refuse_overlap(const void* output, std::int64_t bytes, const char* name) const {
    for (const mesh::ExternalArray& a : arrays)
      if (overlaps(a, output, bytes))
        throw Error(INSITU_ERROR_ARGUMENT, std::string(name) + " overlaps the points");
  }
};

QueryPoints gather_points(const insitu_locate_args& args, const core::Threads& threads) {
  if (args.size != sizeof args)
    throw Error(INSITU_ERROR_ARGUMENT, "make the arguments with insitu_locate_args_default()");
  if (!args.points || (args.point_arrays != 1 && args.point_arrays != 3))
    throw Error(INSITU_ERROR_ARGUMENT,
                !args.points ? std::string("points: the array is null")
                             : "point_arrays: " + std::to_string(args.point_arrays) +
                                   ", 1 or 3 expected");
  if (args.accuracy < INSITU_FAST || args.accuracy > INSITU_EXACT)
    throw Error(INSITU_ERROR_ARGUMENT,
                "accuracy: unknown value " + std::to_string(int(args.accuracy)));
  if (args.cell_base != 0 && args.cell_base != 1)
    throw Error(INSITU_ERROR_ARGUMENT,
                "cell_base: " + std::to_string(args.cell_base) + ", 0 or 1 expected");
  QueryPoints out;
  for (int i = 0; i < args.point_arrays; ++i) {
    out.arrays.push_back(mesh::adopt(args.points + i, "points"));
    mesh::require_real(out.arrays.back(), "points");
    const mesh::ExternalArray& a = out.arrays.back();
    if (a.components != (args.point_arrays == 1 ? 3 : 1) ||
        a.layout.count != out.arrays.front().layout.count)
      throw Error(INSITU_ERROR_ARGUMENT,
                  "points, array " + std::to_string(i) + ": " + std::to_string(a.components) +
                      " components of " + std::to_string(a.layout.count) +
                      " items; one array of 3 components or 3 equal ones of 1 expected");
  }
  const std::int64_t n = out.arrays.front().layout.count;
  out.points.resize(std::size_t(n));
  threads.parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i)
      for (int c = 0; c < 3; ++c) {
        const mesh::ExternalArray& a = out.arrays[args.point_arrays == 1 ? 0 : std::size_t(c)];
        const std::byte* p = a.data + a.layout.offset(i) +
                             (args.point_arrays == 1 ? c * a.component_stride : 0);
        out.points[std::size_t(i)][c] = mesh::load_real(p, a.type == INSITU_FLOAT32);
      }
  });
  return out;
}

} // namespace

std::vector<query::Location> Session::locate_all(query::CommittedMesh& mesh,
                                                 const insitu_locate_args& args) {
  mesh.require_committed();
  QueryPoints query = gather_points(args, context_.threads);
  const auto n = std::int64_t(query.points.size());
  query.refuse_overlap(args.cells, n * 8, "cells");
  query.refuse_overlap(args.pieces, n * 4, "pieces");
  query.refuse_overlap(args.parametric, n * 24, "parametric");
  query.refuse_overlap(args.found, n, "found");
  if (args.frame)
    scene::convert_points(query.points, *args.frame, mesh.frame);
  std::vector<query::Location> locations(query.points.size());
  query::LocateOptions options;
  options.accuracy = args.accuracy;
  mesh.sampler().locate(context_.threads, query.points, locations, options);
  const mesh::MeshView& view = mesh.mesh().view();
  context_.threads.parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      const query::Location& at = locations[std::size_t(i)];
      const std::int32_t piece = at ? view.piece_of(at.cell) : -1;
      if (args.cells)
        args.cells[i] = (at ? at.cell - view.first_cell[piece] : -1) + args.cell_base;
      if (args.pieces)
        args.pieces[i] = piece;
      if (args.found)
        args.found[i] = at ? 1 : 0;
      for (int c = 0; args.parametric && c < 3; ++c)
        args.parametric[3 * i + c] =
            at ? at.parametric[c] : std::numeric_limits<double>::quiet_NaN();
    }
  });
  statistics_.points_located += n;
  statistics_.points_outside +=
      std::count_if(locations.begin(), locations.end(), [](const auto& l) { return !l; });
  return locations;
}

void Session::locate(query::CommittedMesh& mesh, const insitu_locate_args& args) {
  const core::Timer timer;
  (void)locate_all(mesh, args);
  statistics_.query_s += timer.seconds();
}

void Session::sample(query::CommittedMesh& mesh, const insitu_sample_args& args) {
  const core::Timer timer;
  if (args.size != sizeof args)
    throw Error(INSITU_ERROR_ARGUMENT, "make the arguments with insitu_sample_args_default()");
  if (args.field_count < 0 || (args.field_count > 0 && (!args.fields || !args.values)))
    throw Error(INSITU_ERROR_ARGUMENT,
                "field_count is " + std::to_string(args.field_count) +
                    (args.fields ? "" : ", fields is null") + (args.values ? "" : ", values is null"));
  mesh.require_committed();
  const QueryPoints query = gather_points(args.locate, context_.threads);
  const auto n = std::int64_t(query.points.size());
  std::vector<mesh::FieldView> fields;
  std::size_t width = 0;
  for (int f = 0; f < args.field_count; ++f) {
    const std::string item = "[" + std::to_string(f) + "] is null";
    if (!args.fields[f])
      throw Error(INSITU_ERROR_ARGUMENT, "fields" + item);
    if (!args.values[f] && n > 0)
      throw Error(INSITU_ERROR_ARGUMENT, "values" + item);
    fields.push_back(mesh.mesh().field(args.fields[f]));
    query.refuse_overlap(args.values[f], n * fields.back().components * 8, "values");
    width += std::size_t(fields.back().components);
  }
  const std::vector<query::Location> locations = locate_all(mesh, args.locate);
  const query::Sampler sampler = mesh.sampler();
  context_.threads.parallel_for(n, grain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<double> row(width);
    for (std::int64_t i = begin; i < end; ++i) {
      const query::Location& at = locations[std::size_t(i)];
      if (at)
        sampler.interpolate(fields, at, row.data());
      else
        std::fill(row.begin(), row.end(), std::numeric_limits<double>::quiet_NaN());
      const double* from = row.data();
      for (std::size_t f = 0; f < fields.size(); ++f) {
        const int components = fields[f].components;
        std::copy_n(from, components, args.values[f] + i * components);
        from += components;
      }
    }
  });
  statistics_.query_s += timer.seconds();
}

bool Session::sample_point(query::CommittedMesh& mesh, const std::string& field,
                           const double* point, double* values) {
  mesh.require_committed();
  const mesh::FieldView view = mesh.mesh().field(field);
  const query::Sampler sampler = mesh.sampler();
  const query::Location at = sampler.locate({point[0], point[1], point[2]});
  if (at)
    sampler.interpolate(view, at, values);
  else
    std::fill_n(values, view.components, std::numeric_limits<double>::quiet_NaN());
  ++statistics_.points_located;
  statistics_.points_outside += !at;
  return bool(at);
}

} // namespace insitu::api

#include <algorithm>
#include <limits>

#include "api/query_args.h"
#include "api/session.h"
#include "core/status.h"
#include "core/timer.h"
#include "scene/frames.h"

namespace insitu::api {

using core::Error;

namespace {

/// So many points are located at a time: enough for the sampler to sort them well, and a bound on
/// the scratch that any number of points needs.
constexpr std::int64_t slice = std::int64_t(1) << 20;

} // namespace

const query::CommittedMesh& Session::committed(SessionMesh& mesh) {
  mesh.mesh.require_committed();
  if (checked_)
    mesh.watch.expect_unchanged(INSITU_CHANGED_NOTHING, context_.threads);
  return mesh.mesh;
}

void Session::answer(const query::CommittedMesh& mesh, const insitu_locate_args& args,
                     const QueryPoints& points, std::span<const mesh::FieldView> fields,
                     double* const* values) {
  const std::int64_t n = points.count();
  // A conversion that fails must do so before anything is answered.
  const std::int64_t most = args.frame ? n : std::min(n, slice);
  query_points_.resize_discard(std::size_t(most));
  query::LocateOptions options;
  options.accuracy = args.accuracy;
  const mesh::MeshView& view = mesh.mesh().view();
  const query::Sampler sampler = mesh.sampler();
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const std::int64_t outside = mesh.locate_counts().totals()[std::size_t(query::Reason::outside)];
  for (std::int64_t first = 0; first < n; first += most) {
    const std::span where(query_points_.data(), std::size_t(std::min(most, n - first)));
    points.gather(first, where, context_.threads);
    if (args.frame)
      scene::convert_points(where, *args.frame, mesh.frame);
    sampler.visit(context_.threads, where, options,
                  [&](std::size_t k, const query::Location& at, query::Reason reason) {
                    const std::size_t i = std::size_t(first) + k;
                    const std::int32_t piece = at ? view.piece_of(at.cell) : -1;
                    if (args.cells)
                      args.cells[i] = (at ? at.cell - view.first_cell[piece] : -1) + args.cell_base;
                    if (args.pieces)
                      args.pieces[i] = piece;
                    if (args.found)
                      args.found[i] = at ? 1 : 0;
                    if (args.reasons)
                      args.reasons[i] = std::uint8_t(reason);
                    for (int c = 0; args.parametric && c < 3; ++c)
                      args.parametric[3 * i + std::size_t(c)] = at ? at.parametric[c] : nan;
                    if (at)
                      return sampler.interpolate(fields, at, i, values);
                    for (std::size_t f = 0; f < fields.size(); ++f) {
                      const auto components = std::size_t(fields[f].components);
                      std::fill_n(values[f] + i * components, components, nan);
                    }
                  });
  }
  statistics_.points_located += n;
  statistics_.points_outside +=
      mesh.locate_counts().totals()[std::size_t(query::Reason::outside)] - outside;
}

void Session::locate(SessionMesh& to, const insitu_locate_args& args) {
  const core::Timer timer;
  const query::CommittedMesh& mesh = committed(to);
  const QueryPoints points(args);
  QueryOutputs(args, points.count()).refuse_overlaps(points, mesh.mesh(), {});
  answer(mesh, args, points, {}, nullptr);
  statistics_.query_s += timer.seconds();
}

void Session::sample(SessionMesh& to, const insitu_sample_args& args) {
  const core::Timer timer;
  if (args.size != sizeof args)
    throw Error(INSITU_ERROR_ARGUMENT, "make the arguments with insitu_sample_args_default()");
  if (args.field_count < 0 || (args.field_count > 0 && (!args.fields || !args.values)))
    throw Error(INSITU_ERROR_ARGUMENT, "field_count is " + std::to_string(args.field_count) +
                                           (args.fields ? "" : ", fields is null") +
                                           (args.values ? "" : ", values is null"));
  const query::CommittedMesh& mesh = committed(to);
  const QueryPoints points(args.locate);
  const std::int64_t n = points.count();
  QueryOutputs outputs(args.locate, n);
  std::vector<mesh::FieldView> fields;
  for (int f = 0; f < args.field_count; ++f) {
    const std::string item = "[" + std::to_string(f) + "]";
    if (!args.fields[f])
      throw Error(INSITU_ERROR_ARGUMENT, "fields" + item + " is null");
    if (!args.values[f] && n > 0)
      throw Error(INSITU_ERROR_ARGUMENT, "values" + item + " is null");
    fields.push_back(mesh.mesh().field(args.fields[f]));
    outputs.add(args.values[f], n * fields.back().components * 8, "values" + item);
  }
  outputs.refuse_overlaps(points, mesh.mesh(),
                          std::span(args.fields, std::size_t(args.field_count)));
  answer(mesh, args.locate, points, fields, args.values);
  statistics_.query_s += timer.seconds();
}

bool Session::sample_point(SessionMesh& to, const std::string& field, const double* point,
                           double* values) {
  to.mesh.require_committed();
  if (checked_)
    to.watch.expect_unchanged_chunk();
  const query::CommittedMesh& mesh = to.mesh;
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

#include <algorithm>
#include <limits>
#include <optional>

#include "api/query_args.h"
#include "api/session.h"
#include "commit/nearest.h"
#include "core/caller_struct.h"
#include "core/timer.h"
#include "scene/earth/reference_frames.h"

namespace insitu::api {

using core::Error;

namespace {

/// So many points are located at a time: enough for the sampler to sort them well, and a bound on
/// the scratch that any number of points needs.
constexpr std::int64_t slice = std::int64_t(1) << 20;

/// Writes answers where the caller wants them, an array at a time. first: added to the items. view:
/// the mesh's own.
void put_answers(const query::Answered& answered, std::size_t first, const mesh::Mesh& mesh,
                 int rank, const insitu_locate_args& args) {
  const mesh::MeshView& view = mesh.own_view();
  const auto put = [&](auto* to, auto&& value) {
    for (std::size_t k = 0; to && k < answered.locations.size(); ++k)
      to[first + answered.item(k)] = value(k);
  };
  const auto piece_of = [&](const query::Location& at) {
    return !at ? -1 : view.piece_of(at.cell);
  };
  put(args.cells, [&](std::size_t k) {
    const query::Location& at = answered.locations[k];
    return (at ? at.cell - view.first_cell[piece_of(at)] : -1) + args.cell_base;
  });
  put(args.pieces, [&](std::size_t k) { return piece_of(answered.locations[k]); });
  put(args.found,
      [&](std::size_t k) { return std::uint8_t(answered.reasons[k] != query::Reason::outside); });
  put(args.reasons, [&](std::size_t k) { return std::uint8_t(answered.reasons[k]); });
  put(args.ranks, [&](std::size_t k) { return answered.locations[k] ? rank : -1; });
  put(args.global_cells, [&](std::size_t k) {
    const query::Location& at = answered.locations[k];
    return at ? mesh.global_id(INSITU_CELL, at.cell) : std::int64_t(-1);
  });
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t k = 0; args.parametric && k < answered.locations.size(); ++k) {
    const query::Location& at = answered.locations[k];
    double* const to = args.parametric + 3 * (first + answered.item(k));
    for (int c = 0; c < 3; ++c)
      to[c] = at ? at.parametric[c] : nan;
  }
}

/// Answers of which those in a halo's cells are outside, since a query is of this process's own,
/// and those outside are the nearest cells, where these are asked for.
class OwnAnswers {
public:
  /// nearest: null: not asked for. farthest: for them.
  OwnAnswers(const commit::CommittedMesh& mesh, const query::NearestCells* nearest, double farthest)
      : mesh_(mesh), nearest_(nearest), farthest_(farthest) {}

  /// The results are valid as long as the object and what was given.
  query::Answered of(const query::Answered& answered, std::span<const math::Vec3d> points) {
    query::Answered own = answered;
    if (!mesh_.halo() && !nearest_)
      return own;
    locations_.assign(answered.locations.begin(), answered.locations.end());
    reasons_.assign(answered.reasons.begin(), answered.reasons.end());
    for (std::size_t k = 0; mesh_.halo() && k < locations_.size(); ++k)
      if (!mesh_.own_here(locations_[k], points[answered.item(k)])) {
        locations_[k] = {};
        reasons_[k] = query::Reason::outside;
      }
    if (nearest_) {
      find_nearest(answered, points);
      own.one_by_one = {}; // the nearest cells' were
    }
    own.locations = locations_;
    own.reasons = reasons_;
    return own;
  }
  /// The same, given by of(), in the solver's own cells.
  query::Answered as_own(const query::Answered& answered, std::span<const math::Vec3d> points) {
    own_.resize(answered.locations.size());
    for (std::size_t k = 0; k < own_.size(); ++k)
      own_[k] = nearest_ && answered.reasons[k] == query::Reason::outside
                    ? near_[k].at
                    : mesh_.own_here(answered.locations[k], points[answered.item(k)]);
    query::Answered as_own = answered;
    as_own.locations = own_;
    return as_own;
  }
  /// [answer] given by of().
  std::span<const commit::NearestOwn> near() const { return near_; }

private:
  void find_nearest(const query::Answered& answered, std::span<const math::Vec3d> points) {
    near_.resize(locations_.size());
    for (std::size_t k = 0; k < locations_.size(); ++k) {
      const math::Vec3d& p = points[answered.item(k)];
      if (reasons_[k] != query::Reason::outside) {
        near_[k] = {{}, p, 0.0};
        continue;
      }
      const query::NearestCell found = nearest_->find(p, farthest_);
      near_[k] = commit::own_of(mesh_, found);
      locations_[k] = near_[k].at ? found.at : query::Location{};
    }
  }

  const commit::CommittedMesh& mesh_;
  const query::NearestCells* nearest_;
  double farthest_;
  std::vector<query::Location> locations_, own_;
  std::vector<query::Reason> reasons_;
  std::vector<commit::NearestOwn> near_;
};

/// How far the cells that answer are, where nearest ones are asked for.
void put_nearest(const query::Answered& answered, std::span<const commit::NearestOwn> near,
                 std::size_t first, const insitu_locate_args& args) {
  for (std::size_t k = 0; k < near.size(); ++k) {
    const std::size_t i = first + answered.item(k);
    if (args.distances)
      args.distances[i] = near[k].distance;
    for (int c = 0; args.nearest && c < 3; ++c)
      args.nearest[3 * i + std::size_t(c)] = near[k].place[c];
  }
}

} // namespace

commit::CommittedMesh& Session::committed(SessionMesh& to) {
  commit::CommittedMesh& mesh = answering(to);
  mesh.require_committed();
  if (checks(to) && !shown_)
    to.watch.expect_unchanged(INSITU_CHANGED_NOTHING, context_.threads);
  return mesh;
}

void Session::for_each_slice(
    const commit::CommittedMesh& mesh, const insitu_locate_args& args, const QueryPoints& points,
    core::FunctionRef<void(std::int64_t, std::span<const math::Vec3d>)> visit) {
  const std::int64_t n = points.count();
  // A conversion that fails must do so before anything is answered.
  const std::int64_t most = args.frame ? n : std::min(n, slice);
  const insitu_frame from = args.frame ? scene::read_frame(*args.frame) : mesh.reference_frame;
  const math::Vec3d* const in_place = args.frame || mesh.is_flat() ? nullptr : points.in_place();
  if (!in_place)
    query_points_.resize_discard(std::size_t(most));
  for (std::int64_t first = 0; first < n; first += most) {
    const auto count = std::size_t(std::min(most, n - first));
    if (!in_place)
      points.gather(first, {query_points_.data(), count}, context_.threads);
    if (args.frame)
      scene::convert_points({query_points_.data(), count}, from, mesh.reference_frame);
    mesh.to_plane({query_points_.data(), count});
    visit(first, {in_place ? in_place + first : query_points_.data(), count});
  }
}

void Session::answer(const commit::CommittedMesh& mesh, const insitu_locate_args& args,
                     const QueryPoints& points, std::span<const mesh::FieldView> fields,
                     double* const* values) {
  if (args.memory == INSITU_DEVICE)
    return answer_in_device_memory(mesh, args, points, fields, values);
  if (args.outside == INSITU_OUTSIDE_NEAREST)
    commit::require_nearest(mesh);
  if (mesh.device())
    return answer_by_device(mesh, args, points, fields, values);
  query::LocateOptions options;
  options.accuracy = args.accuracy;
  const query::Sampler sampler = mesh.own_sampler();
  const int rank = processes_.world().rank();
  const bool counts_otherwise = mesh.mesh().has_stand_in();
  options.coordinates =
      args.parametric || args.reasons || counts_otherwise || sampler.takes_coordinates(fields);
  std::optional<query::NearestCells> nearest;
  if (args.outside == INSITU_OUTSIDE_NEAREST)
    nearest.emplace(sampler);
  const std::int64_t outside = mesh.locate_counts().totals()[std::size_t(query::Reason::outside)];
  for_each_slice(mesh, args, points, [&](std::int64_t first, std::span<const math::Vec3d> some) {
    sampler.visit(context_.threads, some, options, [&](const query::Answered& of_all) {
      OwnAnswers own(mesh, nearest ? &*nearest : nullptr, farthest_of(args.greatest_distance));
      const query::Answered answered = own.of(of_all, some);
      put_answers(counts_otherwise ? own.as_own(answered, some) : answered, std::size_t(first),
                  mesh.mesh(), rank, args);
      put_nearest(answered, own.near(), std::size_t(first), args);
      if (!fields.empty())
        sampler.interpolate(fields, answered, std::size_t(first), values);
    });
  });
  statistics_.points_located += points.count();
  statistics_.points_outside +=
      mesh.locate_counts().totals()[std::size_t(query::Reason::outside)] - outside;
}

void Session::locate(SessionMesh& to, const insitu_locate_args& args) {
  const core::Timer timer;
  if (args.scope == INSITU_SCOPE_EVERYWHERE) {
    insitu_sample_args as_sample = insitu_sample_args_default();
    as_sample.locate = args;
    ask_everywhere(to, as_sample);
    statistics_.query_s += timer.seconds();
    return;
  }
  const commit::CommittedMesh& mesh = committed(to);
  const QueryPoints points(args);
  QueryOutputs(args, points.count()).refuse_overlaps(points, mesh.mesh(), {});
  answer(mesh, args, points, {}, nullptr);
  statistics_.query_s += timer.seconds();
}

void Session::sample(SessionMesh& to, const insitu_sample_args& given) {
  const core::Timer timer;
  const insitu_sample_args args = core::from_caller(&given, "args");
  if (args.locate.scope == INSITU_SCOPE_EVERYWHERE) {
    ask_everywhere(to, args);
    statistics_.query_s += timer.seconds();
    return;
  }
  require_field_lists(args);
  const commit::CommittedMesh& mesh = committed(to);
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
  const commit::CommittedMesh& mesh = answering(to);
  mesh.require_committed();
  if (checks(to) && !shown_)
    to.watch.expect_unchanged_chunk();
  const mesh::FieldView view = mesh.mesh().field(field);
  if (mesh.lies_on_device()) { // one point is a dear batch there
    insitu_locate_args args = insitu_locate_args_default();
    std::uint8_t found = 0;
    args.found = &found;
    const insitu_array one = insitu_array_of(point, INSITU_FLOAT64, 1, 3);
    args.points = &one;
    answer_by_device(mesh, args, QueryPoints(args), std::span(&view, 1), &values);
    return found != 0;
  }
  ++statistics_.points_located;
  const query::Sampler sampler = mesh.own_sampler();
  math::Vec3d p{point[0], point[1], point[2]};
  mesh.to_plane({&p, 1});
  query::Location at = sampler.locate(p);
  if (at && mesh.halo() && !mesh.own_here(at, p))
    at = {};
  if (at)
    sampler.interpolate(view, at, values);
  else
    std::fill_n(values, view.components, std::numeric_limits<double>::quiet_NaN());
  statistics_.points_outside += !at;
  return bool(at);
}

} // namespace insitu::api

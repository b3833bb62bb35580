/// Queries that any process's cells may answer.
#include <algorithm>
#include <cmath>
#include <limits>

#include "api/query_args.h"
#include "api/session.h"
#include "commit/halo/everywhere.h"
#include "commit/nearest.h"
#include "scene/earth/reference_frames.h"

namespace insitu::api {

using core::Error;

namespace {

/// Writes owners where the caller wants them. item(k): whose is owners[k].
template <class Item>
void put_owners(Item&& item, std::span<const commit::OwnerOfAll> owners,
                const insitu_locate_args& args) {
  const auto put = [&](auto* to, auto outside, auto&& value) {
    for (std::size_t k = 0; to && k < owners.size(); ++k)
      to[item(k)] = owners[k] ? value(owners[k]) : outside;
  };
  using Owner = const commit::OwnerOfAll&;
  put(args.cells, args.cell_base - 1, [&](Owner o) { return o.cell.cell + args.cell_base; });
  put(args.pieces, std::int32_t(-1), [](Owner o) { return o.cell.piece; });
  put(args.found, std::uint8_t(0), [](Owner o) { return std::uint8_t(o.holds()); });
  put(args.reasons, std::uint8_t(0), [](Owner o) { return std::uint8_t(o.reason); });
  put(args.ranks, std::int32_t(-1), [](Owner o) { return std::int32_t(o.cell.rank); });
  put(args.global_cells, std::int64_t(-1), [](Owner o) { return o.cell.global; });
  for (std::size_t k = 0; args.parametric && k < owners.size(); ++k)
    for (int c = 0; c < 3; ++c)
      args.parametric[3 * item(k) + std::size_t(c)] =
          owners[k] ? owners[k].parametric[c] : std::numeric_limits<double>::quiet_NaN();
}

/// Writes values, [owner][column], where the caller wants them.
template <class Item>
void put_values(Item&& item, std::span<const commit::OwnerOfAll> owners,
                std::span<const double> found, std::span<const int> components,
                double* const* values) {
  std::size_t width = 0, column = 0;
  for (const int n : components)
    width += std::size_t(n);
  for (std::size_t f = 0; f < components.size(); ++f) {
    const auto n = std::size_t(components[f]);
    for (std::size_t k = 0; k < owners.size(); ++k)
      std::copy_n(found.begin() + std::ptrdiff_t(k * width + column), n, values[f] + item(k) * n);
    column += n;
  }
}

/// Writes how near owners are. near: null: the points are in them.
void put_nearness(std::size_t item, const math::Vec3d& p, const commit::OwnerOfAll& owner,
                  const commit::NearnessOfAll* near, const insitu_locate_args& args) {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const math::Vec3d place = !owner ? math::Vec3d{nan, nan, nan} : near ? near->place : p;
  if (args.distances)
    args.distances[item] = !owner ? nan : near ? std::sqrt(near->squared) : 0.0;
  for (int c = 0; args.nearest && c < 3; ++c)
    args.nearest[3 * item + std::size_t(c)] = place[c];
}

} // namespace

void Session::ask_everywhere(SessionMesh& to, const insitu_sample_args& asked) {
  const insitu_locate_args& args = asked.locate;
  parallel::World& world = processes_.world();
  world.check_usable();
  if (checked_)
    processes_.wait_for_all("a query everywhere");
  std::vector<math::Vec3d> points;
  std::vector<std::string> names;
  world.agree_after([&] {
    const commit::CommittedMesh& mesh = committed(to);
    const QueryPoints given(args);
    QueryOutputs(args, given.count()).refuse_overlaps(given, mesh.mesh(), {});
    require_field_lists(asked);
    for (int f = 0; f < asked.field_count; ++f) {
      const bool named = asked.fields[f] != nullptr;
      if (!named || (!asked.values[f] && given.count() > 0))
        throw Error(INSITU_ERROR_ARGUMENT, std::string(named ? "values" : "fields") + "[" +
                                               std::to_string(f) + "] is null");
      names.emplace_back(asked.fields[f]);
    }
    if (args.outside == INSITU_OUTSIDE_NEAREST)
      commit::require_nearest(mesh);
    points = points_of(mesh, args, given);
  });
  commit::CommittedMesh& mesh = answering(to);
  world.require_same([&] {
    std::string all;
    for (const std::string& name : names)
      all += name + "\n";
    return std::vector<parallel::Named>{
        {"mesh", mesh.mesh().name()},
        {"accuracy", std::to_string(int(args.accuracy))},
        {"outside", std::to_string(int(args.outside))},
        {"greatest_distance", std::to_string(args.greatest_distance)},
        {"fields", all}};
  });
  if (mesh.needs_halo(world))
    mesh.update_halo(world, context_.threads, context_.log);
  else
    mesh.update_chart(world, context_.threads, context_.log);
  mesh.to_plane(points);
  commit::Everywhere everywhere(mesh, world);
  const std::vector<int> components = everywhere.components(names);
  const bool wants_nearest = args.outside == INSITU_OUTSIDE_NEAREST;
  std::vector<std::size_t> outside; // items
  const auto put = [&](std::size_t first, std::span<const commit::OwnerOfAll> owners,
                       std::span<const double> found) {
    const auto item = [&](std::size_t k) { return first + k; };
    put_owners(item, owners, args);
    put_values(item, owners, found, components, asked.values);
    for (std::size_t k = 0; k < owners.size(); ++k) {
      statistics_.points_outside += !owners[k];
      if (wants_nearest)
        put_nearness(item(k), points[item(k)], owners[k], nullptr, args);
      if (wants_nearest && !owners[k])
        outside.push_back(item(k));
    }
  };
  query::LocateOptions options;
  options.accuracy = args.accuracy;
  everywhere.sample(points, names, options, context_.threads, put);
  statistics_.points_located += std::int64_t(points.size());
  if (!wants_nearest)
    return;
  std::vector<math::Vec3d> places;
  world.agree_after([&] {
    for (const std::size_t i : outside)
      places.push_back(points[i]);
  });
  everywhere.nearest(places, names, farthest_of(args.greatest_distance), context_.threads,
                     [&](std::size_t first, std::span<const commit::OwnerOfAll> owners,
                         std::span<const commit::NearnessOfAll> nearness,
                         std::span<const double> found) {
                       const auto item = [&](std::size_t k) { return outside[first + k]; };
                       put_owners(item, owners, args);
                       put_values(item, owners, found, components, asked.values);
                       for (std::size_t k = 0; k < owners.size(); ++k)
                         put_nearness(item(k), places[first + k], owners[k], &nearness[k], args);
                     });
}

/// The points of a query in the mesh's frame.
std::vector<math::Vec3d> Session::points_of(const commit::CommittedMesh& mesh,
                                            const insitu_locate_args& args,
                                            const QueryPoints& given) {
  std::vector<math::Vec3d> points(std::size_t(given.count()));
  given.gather(0, points, context_.threads);
  if (args.frame)
    scene::convert_points(points, scene::read_frame(*args.frame), mesh.reference_frame);
  return points;
}

} // namespace insitu::api

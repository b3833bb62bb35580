#include "scene/probes/attached_points.h"

#include <utility>

#include "parallel/bytes.h"
#include "query/walk/attached.h"

namespace insitu::scene {

namespace {

template <class T>
std::vector<parallel::Parcel> to_root(const std::vector<T>& items) {
  std::vector<parallel::Parcel> parcels;
  if (!items.empty())
    parcels.push_back({0, parallel::bytes_of(items)});
  return parcels;
}

/// visit(rank, item) of what came, in the order of ranks.
template <class T, class Visit>
void for_each_item(const std::vector<parallel::Parcel>& parcels, Visit&& visit) {
  for (const parallel::Parcel& parcel : parcels)
    for (const T& item : parallel::items_of<T>(parcel.bytes))
      visit(parcel.rank, item);
}

} // namespace

/// A process has a cell that holds a point.
struct AttachedPoints::Claim {
  std::int64_t point;
  std::int64_t chart, cell; ///< as mesh::CellName orders cells: the global id, if cells have them
};

struct AttachedPoints::Moved {
  std::int64_t point;
  math::Vec3d x;
};

/// A point as its owner knows it.
struct AttachedPoints::Placed {
  std::int64_t point, cell;
  math::Vec3d parametric;
  mesh::CellName name;
};

AttachedPoints::Kept AttachedPoints::gather(const commit::CommittedMesh* mesh,
                                            std::vector<math::Vec3d>& points) {
  if (kept_)
    return *kept_;
  share(points);
  std::vector<parallel::Parcel> mine;
  world_.agree_after([&] {
    std::vector<Placed> placed;
    for (std::size_t i = 0; i < places_.size(); ++i)
      if (const query::Location& at = places_[i]; at && owners_[i] == world_.rank())
        placed.push_back({std::int64_t(i), at.cell, at.parametric,
                          mesh ? kept_name(*mesh, at.cell, world_.rank()) : mesh::CellName()});
    mine = to_root(placed);
  });
  const std::vector<parallel::Parcel> all = world_.exchange(mine);
  Kept kept;
  world_.agree_after([&] {
    if (!world_.is_root())
      return;
    kept.cells.assign(places_.size(), -1);
    kept.parametric.resize(places_.size());
    if (mesh && names_cells(*mesh, world_))
      kept.names.resize(places_.size());
    for_each_item<Placed>(all, [&](int, const Placed& at) {
      const auto i = std::size_t(at.point);
      kept.cells[i] = at.cell;
      kept.parametric[i] = at.parametric;
      if (!kept.names.empty())
        kept.names[i] = at.name;
    });
  });
  return kept;
}

/// The points of a restart: each is its process's that has its cell. Returns whether cells are
/// those of the checkpoint.
bool AttachedPoints::bring_home() {
  const bool stand = kept_cells_ && kept_cells_->stand();
  std::vector<std::int64_t> ranks;
  world_.agree_after([&] {
    const std::size_t count = kept_->cells.size();
    places_.assign(count, {});
    ranks.assign(count, world_.size());
    for (std::size_t i = 0; i < count && stand; ++i) {
      const std::int64_t cell =
          kept_->names.empty() ? kept_->cells[i] : kept_cells_->find(kept_->names[i]);
      if (cell < 0)
        continue;
      places_[i] = {cell, kept_->parametric[i]};
      ranks[i] = world_.rank();
    }
  });
  world_.reduce(std::span(ranks), parallel::Reduction::least);
  world_.agree_after([&] {
    owners_.assign(ranks.size(), -1);
    for (std::size_t i = 0; i < ranks.size(); ++i)
      if (ranks[i] < world_.size())
        owners_[i] = std::int32_t(ranks[i]);
  });
  kept_.reset();
  kept_cells_.reset();
  return stand;
}

void AttachedPoints::follow(const commit::CommittedMesh& mesh, const query::LocateOptions& options,
                            bool by_ids, std::vector<math::Vec3d>& points) {
  const bool stand = kept_ && bring_home();
  const bool knows = !places_.empty(); // some may not, whose first call failed
  std::int64_t any[] = {!knows || (topology_ != mesh.own_topology_version() && !stand), !knows};
  world_.reduce(any, parallel::Reduction::greatest);
  const bool other_cells = any[0] != 0;
  if (other_cells && any[1] == 0)
    share(points);
  std::vector<Moved> lost;
  std::vector<std::int64_t> some; // that nobody owns
  std::vector<Claim> claims;
  world_.agree_after([&] {
    if (other_cells) {
      owners_.assign(points.size(), -1);
      places_.assign(points.size(), {});
    }
    for (std::size_t i = 0; i < points.size(); ++i)
      if (owners_[i] < 0)
        some.push_back(std::int64_t(i));
    move(mesh.own_sampler(), options, points, lost);
    claims = locate(mesh, options, by_ids, some, points);
  });
  if (!some.empty())
    settle(some, claims);
  tell_lost(lost, points);
  topology_ = mesh.own_topology_version();
}

/// Tells all processes where the points are.
void AttachedPoints::share(std::vector<math::Vec3d>& points) {
  if (world_.size() == 1)
    return;
  std::vector<parallel::Parcel> mine;
  world_.agree_after([&] {
    std::vector<Moved> moved;
    for (std::size_t i = 0; i < points.size(); ++i)
      if (owners_[i] == world_.rank())
        moved.push_back({std::int64_t(i), points[i]});
    mine = to_root(moved);
  });
  const std::vector<parallel::Parcel> all = world_.exchange(mine);
  world_.agree_after([&] {
    for_each_item<Moved>(all, [&](int, const Moved& m) { points[std::size_t(m.point)] = m.x; });
  });
  world_.broadcast(std::as_writable_bytes(std::span(points)));
}

/// Those that this process owns.
void AttachedPoints::move(const query::Sampler& sampler, const query::LocateOptions& options,
                          std::vector<math::Vec3d>& points, std::vector<Moved>& lost) {
  threads_.parallel_for(std::int64_t(points.size()), 512,
                        [&](std::int64_t begin, std::int64_t end) {
                          for (auto i = std::size_t(begin); i < std::size_t(end); ++i)
                            if (owners_[i] == world_.rank())
                              query::follow(sampler, true, options, places_[i], points[i]);
                        });
  for (std::size_t i = 0; i < points.size(); ++i)
    if (owners_[i] == world_.rank() && !places_[i])
      lost.push_back({std::int64_t(i), points[i]});
}

/// Those that nobody owns and this process's cells hold.
std::vector<AttachedPoints::Claim> AttachedPoints::locate(const commit::CommittedMesh& mesh,
                                                          const query::LocateOptions& options,
                                                          bool by_ids,
                                                          std::span<const std::int64_t> some,
                                                          std::vector<math::Vec3d>& points) {
  std::vector<Claim> claims;
  if (mesh.mesh().own_view().own_cell_count() == 0)
    return claims;
  const query::Sampler sampler = mesh.own_sampler();
  threads_.parallel_for(std::int64_t(some.size()), 512, [&](std::int64_t begin, std::int64_t end) {
    for (const std::int64_t point : some.subspan(std::size_t(begin), std::size_t(end - begin))) {
      const auto i = std::size_t(point);
      query::follow(sampler, false, options, places_[i], points[i]);
    }
  });
  for (const std::int64_t point : some) {
    query::Location& place = places_[std::size_t(point)];
    if (place && world_.size() > 1 && !sampler.owns(place.cell))
      place = {};
    if (!place)
      continue;
    const std::int64_t own = mesh.own(place, points[std::size_t(point)]).cell;
    claims.push_back({point, mesh.stand_in() ? mesh.stand_in()->place(place.cell).chart : 0,
                      by_ids ? mesh.mesh().global_id(INSITU_CELL, own) : 0});
  }
  return claims;
}

/// The lowest cell owns a point: by global ids, or else of the lowest process.
void AttachedPoints::settle(std::span<const std::int64_t> some, const std::vector<Claim>& mine) {
  std::vector<parallel::Parcel> out;
  world_.agree_after([&] { out = to_root(mine); });
  const std::vector<parallel::Parcel> in = world_.exchange(out);
  std::vector<std::pair<std::int64_t, std::int64_t>> cells;
  world_.agree_after([&] {
    cells.resize(world_.is_root() ? owners_.size() : 0);
    for_each_item<Claim>(in, [&](int rank, const Claim& claim) {
      const auto i = std::size_t(claim.point);
      const std::pair cell(claim.chart, claim.cell);
      if (owners_[i] >= 0 && cells[i] <= cell)
        return;
      owners_[i] = rank;
      cells[i] = cell;
    });
  });
  world_.broadcast(std::as_writable_bytes(std::span(owners_)));
  for (const std::int64_t point : some)
    if (owners_[std::size_t(point)] != world_.rank())
      places_[std::size_t(point)] = {};
}

/// Points that left all cells, such as with a vertex that is not finite, are nobody's from now on.
void AttachedPoints::tell_lost(const std::vector<Moved>& lost, std::vector<math::Vec3d>& points) {
  std::int64_t count = std::int64_t(lost.size());
  world_.reduce(std::span(&count, 1), parallel::Reduction::sum);
  if (count == 0)
    return;
  std::vector<Moved> all;
  std::vector<parallel::Parcel> out;
  world_.agree_after([&] {
    all.resize(std::size_t(count));
    out = to_root(lost);
  });
  const std::vector<parallel::Parcel> in = world_.exchange(out);
  world_.agree_after([&] {
    auto to = all.begin();
    for_each_item<Moved>(in, [&](int, const Moved& m) { *to++ = m; });
  });
  world_.broadcast(std::as_writable_bytes(std::span(all)));
  for (const Moved& m : all) {
    owners_[std::size_t(m.point)] = -1;
    points[std::size_t(m.point)] = m.x;
  }
}

} // namespace insitu::scene

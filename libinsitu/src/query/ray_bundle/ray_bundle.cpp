#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "core/count_bits.h"
#include "query/batch/bit_tables.h"
#include "query/lattice/gridlet_query.h"
#include "query/point_query.h"
#include "query/ray_bundle/ray_bundle_scratch.h"

namespace insitu::query {
using math::Vec3d;

namespace {

RayBundleScratch& bundle_scratch() {
  thread_local std::unique_ptr<RayBundleScratch> scratch = std::make_unique<RayBundleScratch>();
  return *scratch;
}

} // namespace

RayBundleLocator::RayBundleLocator(const Sampler& sampler, const LocateOptions& options)
    : sampler_(sampler), options_(options), s_(bundle_scratch()) {
  const PointQuery query{sampler.mesh(), sampler.tree(), options};
  const ProofRule proof = query.proof();
  ranked_ = !proof.for_all();
  usable_ = !sampler.tree().empty() && proof.for_some() && options.alpha == 1.0 &&
            proof.is_enough() && sampler.locator().answers_by_proof(options) &&
            (!gridlets_of(sampler.mesh()) || sampler.locator().dual());
  const mesh::MeshView& mesh = sampler.mesh();
  has_blocks_ =
      !sampler.chart() && std::any_of(mesh.pieces, mesh.pieces + mesh.piece_count, has_places);
}

/// Neighbours, four by four, into one group.
void RayBundleLocator::set_rays(std::span<const LatticeRay> rays, int row, double step) {
  constexpr int side = 4;
  static_assert(side * side == bundle_lanes);
  rays_ = int(rays.size());
  step_ = step;
  const int across = row > 0 ? (row + side - 1) / side : 0;
  const int down = row > 0 ? ((rays_ + row - 1) / row + side - 1) / side : 0;
  const bool tiled = row > 0 && across * down <= bundle_groups;
  row_ = tiled ? std::min(row, rays_) : rays_;
  groups_ = tiled ? across * down : (rays_ + bundle_lanes - 1) / bundle_lanes;
  one_origin_ = true;
  if (rays_ > 0 && rays_ < groups_ * bundle_lanes) // the others are like the first
    for (int slot = 0; slot < groups_ * bundle_lanes; ++slot)
      s_.rays.set(slot, rays[0].origin, rays[0].direction);
  s_.far = 0.0;
  s_.mean_origin = s_.mean_direction = {};
  for (int r = 0; r < rays_; ++r) {
    const int x = tiled ? r % row : 0, y = tiled ? r / row : 0;
    const int slot =
        tiled ? (y / side * across + x / side) * bundle_lanes + y % side * side + x % side : r;
    s_.slot[r] = std::uint16_t(slot);
    s_.rays.set(slot, rays[std::size_t(r)].origin, rays[std::size_t(r)].direction);
    const Vec3d off = rays[std::size_t(r)].origin - rays[0].origin;
    one_origin_ = one_origin_ && off.x == 0.0 && off.y == 0.0 && off.z == 0.0;
    s_.mean_origin += rays[std::size_t(r)].origin;
    s_.mean_direction += rays[std::size_t(r)].direction;
    for (int a = 0; a < 3; ++a)
      s_.far = std::max(s_.far, std::fabs(rays[std::size_t(r)].origin[a]));
  }
  s_.mean_origin = s_.mean_origin / double(std::max(rays_, 1));
  s_.mean_direction = s_.mean_direction / double(std::max(rays_, 1));
}

/// At most most_depth.
void RayBundleLocator::answer(std::span<const std::uint16_t> places,
                              std::span<const Location> at) const {
  double values[most_depth];
  if (from_)
    from_->at(at, values);
  for (std::size_t n = 0; n < places.size(); ++n) {
    const int i = s_.answer[slot_of(places[n])] + index_of(places[n]);
    if (locations_)
      locations_[i] = at[n];
    if (from_)
      value_samples_[i] = {at[n].cell, values[n]};
  }
}

void RayBundleLocator::locate(std::int64_t first, int depth, std::span<const std::uint32_t> wanted,
                              std::span<Location> locations) {
  locations_ = locations.data();
  run(first, depth, wanted);
}

void RayBundleLocator::locate(std::int64_t first, int depth, std::span<const std::uint32_t> wanted,
                              const CellValues& from, std::span<ValueSample> samples,
                              std::span<Location> locations) {
  from_ = &from;
  value_samples_ = samples.data();
  locations_ = locations.empty() ? nullptr : locations.data();
  run(first, depth, wanted);
  from_ = nullptr;
  value_samples_ = nullptr;
}

void RayBundleLocator::run(std::int64_t first, int depth, std::span<const std::uint32_t> wanted) {
  first_ = first;
  depth_ = depth;
  std::fill_n(s_.by_reason, reason_count, 0);
  s_.rest.clear();
  const int asked = take_wanted(wanted);
  if (asked == 0)
    return;
  const bool has_slab = options_.alpha == 1.0 && set_slab();
  const bool tried = usable_ && has_slab && claim_in_all_cells(asked);
  if (!tried) {
    for (int slot = 0; slot < groups_ * bundle_lanes; ++slot)
      for_each_bit(s_.wanted[slot], [&](int k) { leave(place_of(k, slot)); });
  }
  s_.by_reason[int(Reason::certified)] +=
      asked - std::int64_t(s_.rest.size()) - s_.by_reason[int(Reason::outside)];
  locate_rest(!has_slab || (tried && !ranked_));
  sampler_.count(s_.by_reason);
}

/// How many.
int RayBundleLocator::take_wanted(std::span<const std::uint32_t> wanted) {
  std::fill_n(s_.wanted, bundle_rays, 0u);
  const std::uint32_t within = ~std::uint32_t(0) >> (bundle_depth - depth_);
  int count = 0;
  for (std::size_t r = 0; r < wanted.size(); ++r) {
    s_.wanted[s_.slot[r]] = wanted[r] & within;
    s_.answer[s_.slot[r]] = std::int32_t(r) * depth_;
    count += int(core::count_bits(wanted[r] & within));
  }
  samples_ += count;
  return count;
}

/// Of so many samples. False, and s_.wanted says which are left, if cells are too many for it to
/// pay.
bool RayBundleLocator::claim_in_all_cells(int samples) {
  const mesh::MeshView& mesh = sampler_.mesh();
  set_states(s_.wanted, s_.slab);
  const auto leave_out = [&](int claimed) {
    samples -= claimed;
    if (claimed == 0 || samples == 0)
      return;
    clear_claimed(s_.slab, s_.wanted);
    bound_groups(s_.wanted, s_.slab);
  };
  if (has_blocks_ && !ranked_)
    leave_out(claim_in_blocks());
  // A batch takes about as long for a sample as this does for two cells, or one of tetrahedra,
  // whose boxes tell a batch little.
  const auto most_cells = [&] { return std::size_t(trying_pays(mesh) ? samples / 2 : samples); };
  std::size_t found = 0;
  if (samples > 0 && !find_cells(sampler_.tree(), s_.slab, most_cells(), s_.found, found))
    return false;
  leave_out(claim_in_gridlets(found));
  if (samples == 0)
    return true;
  if (found > most_cells())
    return false;
  if (ranked_)
    for (int k = 0; k < depth_; ++k)
      std::fill_n(s_.slab.piece[k], groups_ * bundle_lanes, mesh.piece_count);
  const cells::CellGather gather(mesh, 1.0);
  for (ShapeCells& of : s_.by_shape)
    of.clear();
  for (std::size_t i = 0; i < found; ++i) {
    const std::uint32_t slot = s_.found[i];
    const std::int64_t cell = sampler_.tree().cells()[slot];
    const mesh::Shape shape = gather.shape(cell);
    if (shape == mesh::Shape::none)
      continue;
    ShapeCells& of = s_.by_shape[int(shape) - first_shape];
    of.cells.push_back(cell);
    if (ranked_)
      of.ranks.push_back(sampler_.tree().odd().has(slot) ? -1 : mesh.piece_of(cell));
  }
  for (int i = 0; i < shape_count; ++i)
    claim_in_shape(gather, mesh::Shape(first_shape + i), s_.by_shape[i]);
  for (int g = 0; g < groups_; ++g)
    settle_group(g);
  return true;
}

BundleClaims RayBundleLocator::claims() {
  BundleClaims to{};
  to.rays = &s_.rays;
  to.one_origin = one_origin_;
  to.first = double(first_);
  to.step = step_;
  to.answer = s_.answer;
  to.values = &s_.values;
  to.values_at_vertices = from_ && !from_->is_per_cell();
  to.samples = value_samples_;
  to.locations = locations_;
  return to;
}

void RayBundleLocator::claim_in_shape(const cells::CellGather& gather, mesh::Shape shape,
                                      const ShapeCells& of) {
  constexpr std::size_t size = cells::CellBlock::size;
  BundleClaims to = claims();
  const std::size_t count = of.cells.size();
  for (std::size_t at = 0; at < count; at += size) {
    cells::CellBlock& block = s_.block;
    block.count = int(std::min(count - at, size));
    to.cells = &of.cells[at];
    gather.fill(to.cells, block.count, int(count - at) - block.count, block);
    block.fill_up(shape);
    if (from_)
      from_->load({to.cells, std::size_t(block.count)}, s_.values);
    claim_cells(shape, block, of.ranks.empty() ? nullptr : &of.ranks[at], s_.slab, s_.lists, to);
  }
}

/// What became of a group's samples, when all cells have been looked at.
void RayBundleLocator::settle_group(int g) {
  const BundleSlab& slab = s_.slab;
  const int count = find_unclaimed(g, slab, s_.unclaimed);
  for (int n = 0; n < count; ++n) {
    const auto place = std::uint16_t(s_.unclaimed[n]);
    if (slab.state[index_of(place)][slot_of(place)] == touched) {
      leave(place);
      continue;
    }
    const Location none;
    answer({&place, 1}, {&none, 1});
    ++s_.by_reason[int(Reason::outside)];
  }
  if (!ranked_)
    return;
  // A lower piece's cell that may hold it comes first, and an odd one may as well.
  for (int slot = g * bundle_lanes; slot < (g + 1) * bundle_lanes; ++slot)
    for_each_bit(s_.wanted[slot], [&](int k) {
      if (slab.state[k][slot] != claimed)
        return;
      const std::int32_t lowest = slab.piece[k][slot];
      if (lowest < 0 || lowest < sampler_.mesh().piece_of(cell_at(place_of(k, slot))))
        leave(place_of(k, slot));
    });
}

inline void RayBundleLocator::leave(int place) {
  s_.rest.push_back(std::uint16_t(place));
}

/// Of the answer that was given.
std::int64_t RayBundleLocator::cell_at(int place) const {
  const int at = s_.answer[slot_of(place)] + index_of(place);
  return locations_ ? locations_[at].cell : value_samples_[at].cell;
}

/// tried: whether the owners of what is left have been tried already.
void RayBundleLocator::locate_rest(bool tried) {
  if (s_.rest.empty())
    return;
  s_.points.clear();
  for (const std::uint16_t place : s_.rest)
    s_.points.push_back(point(place));
  left_ += std::int64_t(s_.rest.size());
  s_.answers.resize(s_.rest.size());
  sampler_.locate_serial(s_.points, s_.answers, options_);
  if (!tried)
    claim_in_owners();
  const std::span<const std::uint16_t> places(s_.rest);
  const std::span<const Location> at(s_.answers);
  for (std::size_t first = 0; first < places.size(); first += most_depth) {
    const std::size_t n = std::min<std::size_t>(most_depth, places.size() - first);
    answer(places.subspan(first, n), at.subspan(first, n));
  }
}

/// Claims what is left in the cells that have been found to own it, so that coordinates are those
/// of a claim whatever else the mesh has. Only hexahedra's differ otherwise.
void RayBundleLocator::claim_in_owners() {
  const cells::CellGather gather(sampler_.mesh(), 1.0);
  const std::int64_t first_single = sampler_.mesh().first_single_cell();
  for (ShapeCells& of : s_.by_shape)
    of.clear();
  for (int k = 0; k < depth_; ++k)
    std::fill_n(s_.slab.state[k], groups_ * bundle_lanes, unwanted);
  for (std::size_t i = 0; i < s_.rest.size(); ++i) {
    const std::int64_t cell = s_.answers[i].cell;
    const mesh::Shape shape = cell < first_single ? mesh::Shape::none : gather.shape(cell);
    if (shape != mesh::Shape::hexahedron && shape != mesh::Shape::voxel)
      continue;
    s_.slab.state[index_of(s_.rest[i])][slot_of(s_.rest[i])] = untouched;
    std::vector<std::int64_t>& cells = s_.by_shape[int(shape) - first_shape].cells;
    if (cells.empty() || cells.back() != cell) // many follow each other along a ray
      cells.push_back(cell);
  }
  if (has_blocks_)
    claim_in_blocks();
  for (int i = 0; i < shape_count; ++i) {
    std::vector<std::int64_t>& cells = s_.by_shape[i].cells;
    std::sort(cells.begin(), cells.end());
    cells.erase(std::unique(cells.begin(), cells.end()), cells.end());
    claim_in_shape(gather, mesh::Shape(first_shape + i), s_.by_shape[i]);
  }
  std::size_t kept = 0;
  for (std::size_t i = 0; i < s_.rest.size(); ++i) {
    const std::uint16_t place = s_.rest[i];
    if (s_.slab.state[index_of(place)][slot_of(place)] == claimed &&
        cell_at(place) == s_.answers[i].cell)
      continue;
    s_.rest[kept] = place;
    s_.answers[kept++] = s_.answers[i];
  }
  s_.rest.resize(kept);
  s_.answers.resize(kept);
}

} // namespace insitu::query

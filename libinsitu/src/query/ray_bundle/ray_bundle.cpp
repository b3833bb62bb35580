#include <algorithm>
#include <memory>
#include <vector>

#include "core/count_bits.h"
#include "query/batch/bit_tables.h"
#include "query/lattice/dual_query.h"
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
  ranked_ = sampler.mesh().piece_count > 1 || !proof.for_all();
  usable_ = !sampler.tree().empty() && proof.for_some() && options.alpha == 1.0 &&
            proof.is_enough() && sampler.locator().answers_by_proof(options);
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
  groups_ = tiled ? across * down : (rays_ + bundle_lanes - 1) / bundle_lanes;
  std::fill_n(s_.ray, bundle_rays, std::uint16_t(bundle_rays));
  for (int r = 0; r < rays_; ++r) {
    const int x = tiled ? r % row : 0, y = tiled ? r / row : 0;
    const int slot =
        tiled ? (y / side * across + x / side) * bundle_lanes + y % side * side + x % side : r;
    s_.slot[r] = std::uint16_t(slot);
    s_.ray[slot] = std::uint16_t(r);
    s_.origin[slot] = rays[std::size_t(r)].origin;
    s_.direction[slot] = rays[std::size_t(r)].direction;
  }
}

/// At most most_depth.
void RayBundleLocator::answer(std::span<const std::uint16_t> places,
                              std::span<const Location> at) const {
  double values[most_depth];
  if (from_)
    from_->at(at, values);
  for (std::size_t n = 0; n < places.size(); ++n) {
    const int i = int(s_.ray[slot_of(places[n])]) * depth_ + index_of(places[n]);
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
}

void RayBundleLocator::run(std::int64_t first, int depth, std::span<const std::uint32_t> wanted) {
  first_ = first;
  depth_ = depth;
  std::fill_n(s_.by_reason, reason_count, 0);
  s_.rest.clear();
  if (!take_wanted(wanted))
    return;
  if (usable_ && sampler_.locator().dual())
    locate_by_place();
  if (usable_ && set_slab() && enter_all_cells()) {
    prove(false);
    prove(true);
  } else {
    for (int slot = 0; slot < groups_ * bundle_lanes; ++slot)
      for_each_bit(s_.wanted[slot], [&](int k) { leave(place_of(k, slot)); });
  }
  locate_rest();
  sampler_.count(s_.by_reason);
}

/// False if none is.
bool RayBundleLocator::take_wanted(std::span<const std::uint32_t> wanted) {
  std::fill_n(s_.wanted, bundle_rays, 0u);
  const std::uint32_t within = ~std::uint32_t(0) >> (bundle_depth - depth_);
  std::uint32_t any = 0;
  for (std::size_t r = 0; r < wanted.size(); ++r) {
    any |= s_.wanted[s_.slot[r]] = wanted[r] & within;
    samples_ += core::count_bits(wanted[r] & within);
  }
  return any != 0;
}

/// Without the tree, which is then asked for the others alone.
void RayBundleLocator::locate_by_place() {
  DualFinder finder(*sampler_.locator().dual());
  Vec3d points[most_depth];
  std::uint16_t places[most_depth];
  Location at[most_depth];
  for (int slot = 0; slot < groups_ * bundle_lanes; ++slot) {
    std::size_t count = 0, found = 0;
    for_each_bit(s_.wanted[slot], [&](int k) {
      places[count] = std::uint16_t(place_of(k, slot));
      points[count] = point(places[count]);
      ++count;
    });
    for (std::size_t q = 0; q < count; ++q) {
      Reason why;
      std::int64_t guess = -1; // which the bundle finds as well
      at[found] = {};
      if (!finder.find(points[q], at[found], why, guess))
        continue;
      s_.wanted[slot] &= ~(std::uint32_t(1) << index_of(places[q]));
      ++s_.by_reason[int(why)];
      places[found++] = places[q];
    }
    answer({places, found}, {at, found});
  }
}

/// False if cells are too many for it to pay.
bool RayBundleLocator::enter_all_cells() {
  BundleSlab& slab = s_.slab;
  const mesh::MeshView& mesh = sampler_.mesh();
  int samples = 0;
  for (int slot = 0; slot < groups_ * bundle_lanes; ++slot)
    samples += int(core::count_bits(s_.wanted[slot]));
  s_.open.clear();
  s_.runs.clear();
  if (samples == 0)
    return true;
  std::size_t found = 0;
  // A cell takes as long as a sample does by itself.
  if (!find_cells(sampler_.tree(), slab, std::uint32_t(mesh.first_single_cell()),
                  std::size_t(samples) * 3 / 4, s_.found, found))
    return false;
  for (int k = 0; k < depth_; ++k) {
    std::fill_n(slab.best[k], groups_ * bundle_lanes, 0);
    std::fill_n(slab.second[k], groups_ * bundle_lanes, 0);
    if (ranked_)
      std::fill_n(slab.piece[k], groups_ * bundle_lanes, mesh.piece_count);
  }
  const cells::CellGather gather(mesh, 1.0);
  constexpr int first_shape = int(mesh::Shape::tetrahedron), shapes = 5;
  for (int i = 0; i < shapes; ++i) {
    const auto shape = mesh::Shape(first_shape + i);
    if (!gather.one_shape())
      enter_shape(gather, shape, {s_.found.data(), found});
    else if (found > 0 && gather.shape(0) == shape)
      enter_shape(gather, shape, {s_.found.data(), found});
  }
  for (int slot = 0; slot < groups_ * bundle_lanes; ++slot)
    for_each_bit(s_.wanted[slot], [&](int k) {
      if (slab.best[k][slot] != 0)
        return s_.open.push_back(std::uint16_t(place_of(k, slot)));
      const auto place = std::uint16_t(place_of(k, slot));
      const Location none;
      answer({&place, 1}, {&none, 1});
      ++s_.by_reason[int(Reason::outside)];
    });
  return true;
}

/// Those of the found cells that have the shape. Cells are numbered block by block, so that a
/// shape's begin with a block of their own.
void RayBundleLocator::enter_shape(const cells::CellGather& gather, mesh::Shape shape,
                                   std::span<const std::uint32_t> found) {
  constexpr int size = cells::CellBlock::size;
  const mesh::MeshView& mesh = sampler_.mesh();
  const int begin = s_.runs.empty() ? 0 : s_.runs.back().end;
  int end = begin;
  if (s_.cells.size() < std::size_t(begin) + found.size() + size)
    s_.cells.resize(std::size_t(begin) + found.size() + size);
  s_.ranks.resize(s_.cells.size());
  const accel::Tree& tree = sampler_.tree();
  for (const std::uint32_t slot : found) {
    const std::int64_t cell = tree.cells()[slot];
    if (!gather.one_shape() && gather.shape(cell) != shape)
      continue;
    if (ranked_)
      s_.ranks[std::size_t(end)] = tree.odd().has(slot) ? -1 : mesh.piece_of(cell);
    s_.cells[std::size_t(end++)] = cell;
  }
  if (end == begin)
    return;
  const int past = begin + (end - begin + size - 1) / size * size;
  s_.runs.push_back({shape, begin, past});
  if (s_.blocks.size() < std::size_t(past / size))
    s_.blocks.resize(std::size_t(past / size) + 8);
  for (int at = begin; at < end; at += size) {
    cells::CellBlock& block = s_.blocks[std::size_t(at / size)];
    block.count = std::min(end - at, size);
    gather.fill(&s_.cells[std::size_t(at)], block.count, end - at - block.count, block);
    block.fill_up(shape);
    if (from_) {
      if (s_.values.size() < s_.blocks.size())
        s_.values.resize(s_.blocks.size());
      from_->load({&s_.cells[std::size_t(at)], std::size_t(block.count)},
                  s_.values[std::size_t(at / size)]);
    }
    if (ranked_)
      enter_cells(shape, block, at, &s_.ranks[std::size_t(at)], s_.slab);
    else
      enter_cells(shape, block, at, s_.slab);
  }
}

/// Each open sample's likeliest cell, or its second, by Newton. Those that neither is proven to
/// hold are left.
void RayBundleLocator::prove(bool second) {
  const auto key = [&](int place) {
    const BundleSlab& slab = s_.slab;
    const auto& keys = second ? slab.second : slab.best;
    return keys[index_of(place)][slot_of(place)];
  };
  if (s_.open.empty())
    return;
  // Samples in the order of their cells.
  const auto numbers = std::size_t(s_.runs.back().end);
  s_.count.assign(numbers + 1, 0);
  for (const std::uint16_t place : s_.open)
    ++s_.count[std::size_t(cell_of_key(key(place))) + 1];
  for (std::size_t c = 0; c < numbers; ++c)
    s_.count[c + 1] += s_.count[c];
  s_.sorted.resize(s_.open.size());
  for (const std::uint16_t place : s_.open)
    s_.sorted[s_.count[std::size_t(cell_of_key(key(place)))]++] = place;
  s_.open.clear();
  std::size_t begin = 0; // counts are now where the next cell's samples begin
  for (const RayBundleScratch::Run& run : s_.runs) {
    const std::size_t end = s_.count[std::size_t(run.end) - 1];
    for (; begin < end; begin = std::min(end, begin + BundleSamples::size))
      prove_some(run.shape,
                 {&s_.sorted[begin], std::min<std::size_t>(end - begin, BundleSamples::size)},
                 second);
  }
}

void RayBundleLocator::prove_some(mesh::Shape shape, std::span<const std::uint16_t> places,
                                  bool second) {
  BundleSamples& samples = s_.samples;
  const BundleSlab& slab = s_.slab;
  const auto& keys = second ? slab.second : slab.best;
  const int count = int(places.size());
  for (int i = 0; i < count; ++i) {
    const int place = places[std::size_t(i)];
    const Vec3d p = point(place);
    samples.cell[i] = std::uint16_t(cell_of_key(keys[index_of(place)][slot_of(place)]));
    for (int a = 0; a < 3; ++a)
      samples.point[a][i] = p[a];
  }
  for (int i = count; i < count + 8; ++i) // what idle lanes read
    for (int a = 0; a < 3; ++a)
      samples.point[a][i] = samples.point[a][count - 1];
  const bool at_vertices = from_ && !from_->is_per_cell();
  invert(shape, s_.blocks.data(), at_vertices ? s_.values.data() : nullptr, 0, count, samples);
  if (from_ && !at_vertices)
    for (int i = 0; i < count; ++i) {
      const unsigned c = samples.cell[i];
      samples.value[i] =
          s_.values[c / cells::CellBlock::size].vertex[0][c % cells::CellBlock::size];
    }
  for (int i = 0; i < count; ++i) {
    const int place = places[std::size_t(i)];
    const double margin = samples.margin[i], error = samples.error[i];
    if (margin > error) {
      const std::int64_t cell = s_.cells[samples.cell[i]];
      // A lower piece's cell that may hold it comes first, and an odd one may as well.
      if (const std::int32_t lowest = ranked_ ? slab.piece[index_of(place)][slot_of(place)] : 0;
          ranked_ && (lowest < 0 || lowest < s_.ranks[samples.cell[i]])) {
        leave(place);
        continue;
      }
      const int at = int(s_.ray[slot_of(place)]) * depth_ + index_of(place);
      if (locations_)
        locations_[at] = {
            cell, {samples.parametric[0][i], samples.parametric[1][i], samples.parametric[2][i]}};
      if (from_)
        value_samples_[at] = {cell, samples.value[i]};
      ++s_.by_reason[int(Reason::certified)];
    } else if (!second && !is_on_boundary(margin, error) &&
               slab.second[index_of(place)][slot_of(place)] != 0) {
      s_.open.push_back(std::uint16_t(place));
    } else {
      leave(place);
    }
  }
}

inline void RayBundleLocator::leave(int place) {
  s_.rest.push_back(std::uint16_t(place));
}

void RayBundleLocator::locate_rest() {
  if (s_.rest.empty())
    return;
  s_.points.clear();
  for (const std::uint16_t place : s_.rest)
    s_.points.push_back(point(place));
  left_ += std::int64_t(s_.rest.size());
  s_.answers.resize(s_.rest.size());
  sampler_.locate_serial(s_.points, s_.answers, options_);
  const std::span<const std::uint16_t> places(s_.rest);
  const std::span<const Location> at(s_.answers);
  for (std::size_t first = 0; first < places.size(); first += most_depth) {
    const std::size_t n = std::min<std::size_t>(most_depth, places.size() - first);
    answer(places.subspan(first, n), at.subspan(first, n));
  }
}

} // namespace insitu::query

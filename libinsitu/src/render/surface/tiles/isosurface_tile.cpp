#include "render/surface/tiles/isosurface_tile.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "accel/camera_rays/frustum_traversal.h"
#include "render/surface/tiles/active_cell.h"
#include "render/surface/tiles/patches.h"

namespace insitu::render {

namespace {

using math::Vec3d;
using Group = IsosurfaceTracer::Group;
using Level = IsosurfaceTracer::Level;

static_assert(IsosurfaceTile::side == TileRange::side);

/// Cells between two looks at how far a tile is open.
constexpr int look_after = 64;
/// Of a depth: what float's rounding and twins may make of it.
constexpr double depth_slack = 1e-6;

} // namespace

struct IsosurfaceTile::Work {
  /// Cells that hold a level of one group, of one domain.
  struct Batch {
    Patches patches; ///< f: before a level is taken away
    std::int64_t cell[Patches::most];
    double low[Patches::most], high[Patches::most];
  };
  struct CellHit {
    std::int32_t pixel;
    double depth;
    Vec3d parametric;
  };
  struct Record {
    SurfaceHit hit;
    std::int32_t next; ///< of the same pixel, or -1
  };

  const IsosurfaceTracer* surfaces = nullptr;
  const RayGenerator* rays = nullptr;
  const std::vector<Clip>* clips = nullptr;
  SurfaceCounts* counts = nullptr;
  ViewSpace view;
  TileRange tile{};
  alignas(64) float farthest[TileRange::pixels];
  int unlooked = 0;
  double open_to = 0;

  std::vector<Batch> batches; ///< by group, three domains each
  PatchHits found;
  // Of the current cell and level.
  std::vector<CellHit> cell_hits;
  std::uint64_t unsure[TileRange::pixels / 64] = {};
  bool has_unsure = false;

  std::vector<Record> records;
  std::int32_t first[TileRange::pixels];
  std::vector<Stretch> stays;
  IsosurfaceTracer::LastCell last;

  void begin(int x0, int y0, int x1, int y1) {
    tile = {x0, y0, x1 - 1, y1 - 1, view.column(x0), view.row(y0), farthest};
    std::fill(std::begin(farthest), std::end(farthest), -HUGE_VALF);
    for (int y = 0; y < y1 - y0; ++y)
      for (int x = 0; x < x1 - x0; ++x)
        farthest[TileRange::index(x, y)] = HUGE_VALF;
    std::fill(std::begin(first), std::end(first), -1);
    records.clear();
    batches.resize(3 * surfaces->groups().size());
    for (std::size_t i = 0; i < batches.size(); ++i) {
      batches[i].patches = {};
      batches[i].patches.domain = PatchDomain(i % 3);
    }
    last.surface = -1;
    unlooked = 0;
    open_to = HUGE_VAL;
  }

  double look() {
    if (++unlooked >= look_after) {
      unlooked = 0;
      open_to = *std::max_element(std::begin(farthest), std::end(farthest));
    }
    return open_to;
  }

  void add_item(std::int64_t flat) {
    const mesh::MeshView& mesh = surfaces->sampler().mesh();
    const std::int32_t p = mesh.piece_of(flat);
    const mesh::PieceView& piece = mesh.pieces[p];
    const std::int64_t first_of_piece = mesh.first_cell[p];
    if (piece.is_halo)
      return;
    if (!piece.in_runs()) {
      if (piece.is_own(flat - first_of_piece))
        add_cell(flat);
      return;
    }
    for (std::int64_t cell = flat; cell < flat + piece.cells_an_item(); ++cell)
      if (piece.owns(cell - first_of_piece))
        add_cell(cell);
  }

  void add_cell(std::int64_t flat) {
    ++counts->cells_tested;
    for_each_active(*surfaces, flat, view, [&](const ActiveCell& cell) {
      const auto group = std::size_t(cell.group - surfaces->groups().data());
      Batch& batch = batches[3 * group + std::size_t(cell.domain)];
      const int at = batch.patches.count++;
      cell.put(batch.patches, at);
      batch.cell[at] = flat;
      batch.low[at] = cell.low;
      batch.high[at] = cell.high;
      if (batch.patches.count == Patches::most)
        process(batch, *cell.group);
    });
  }

  void flush() {
    for (std::size_t i = 0; i < batches.size(); ++i)
      if (batches[i].patches.count > 0)
        process(batches[i], surfaces->groups()[i / 3]);
  }

  void process(Batch& batch, const Group& group) {
    Patches& all = batch.patches;
    Patches at_level = all; // its idle lanes hold cells of before
    for (const Level& level : group.levels) {
      for (int c = 0; c < 8; ++c)
        for (int k = 0; k < Patches::most; ++k)
          at_level.f[c][k] = all.f[c][k] - level.value;
      PatchSetup setup;
      set_up(at_level, tile, view.orthographic, setup);
      for (int k = 0; k < all.count; ++k)
        if (batch.low[k] < level.value && level.value <= batch.high[k]) {
          descend(at_level, setup, k, 0);
          finish(batch.cell[k], all, k, group, level);
        }
    }
    all.count = 0;
  }

  void descend(const Patches& patches, const PatchSetup& setup, int p, int depth) {
    if (setup.x0[p] > setup.x1[p] || setup.y0[p] > setup.y1[p] || !is_visible(setup, p, tile))
      return;
    const bool is_proven =
        setup.error[p] <= most_error && setup.noise[p] < most_noise && setup.size[p] < most_size;
    if (is_proven || depth == most_splits) {
      found.count = found.unsure = 0;
      if (is_proven)
        solve(patches, setup, p, tile, view.orthographic, found);
      else
        mark_unsure(patches, setup, p, tile, view.orthographic, found);
      for (int i = 0; i < found.count; ++i)
        cell_hits.push_back(
            {found.pixel[i],
             found.depth[i],
             {found.parametric[0][i], found.parametric[1][i], found.parametric[2][i]}});
      for (int i = 0; i < found.unsure; ++i)
        unsure[found.unsure_pixel[i] >> 6] |= std::uint64_t(1) << (found.unsure_pixel[i] & 63);
      has_unsure = has_unsure || found.unsure > 0;
      return;
    }
    Patches parts;
    PatchSetup part_setup;
    split(patches, p, parts);
    set_up(parts, tile, view.orthographic, part_setup);
    for (int k = 0; k < parts.count; ++k)
      if (is_in_domain(parts, k))
        descend(parts, part_setup, k, depth + 1);
  }

  bool is_unsure(std::int32_t pixel) const { return unsure[pixel >> 6] >> (pixel & 63) & 1; }

  /// Takes what was found of a cell, and lets rays decide what was not.
  void finish(std::int64_t cell, const Patches& corners, int k, const Group& group,
              const Level& level) {
    if (!cell_hits.empty()) {
      const double reach[3] = {std::fabs(corners.x[7][k] - corners.x[0][k]),
                               std::fabs(corners.y[7][k] - corners.y[0][k]),
                               std::fabs(corners.z[7][k] - corners.z[0][k])};
      const double extent = reach[2] + view.pixel * (reach[0] + reach[1]);
      for (const CellHit& at : cell_hits) {
        if (has_unsure && is_unsure(at.pixel))
          continue;
        LevelHit root;
        root.t = at.depth * length_at(at.pixel);
        root.parametric = at.parametric;
        root.gradient.x =
            std::numeric_limits<double>::quiet_NaN(); // found when it is known to stay
        if (root.t >= 0)
          take(IsosurfaceTracer::hit_of(root, extent, cell, level), at.pixel, at.depth,
               clipped(at.pixel));
      }
      cell_hits.clear();
    }
    if (!has_unsure)
      return;
    has_unsure = false;
    for (int word = 0; word < TileRange::pixels / 64; ++word)
      for (; unsure[word]; unsure[word] &= unsure[word] - 1)
        search(64 * word + std::countr_zero(unsure[word]), cell, group, level);
  }

  /// Searches the cell by the pixel's ray.
  void search(std::int32_t pixel, std::int64_t cell, const Group& group, const Level& level) {
    double from = 0, to = std::numeric_limits<double>::max();
    const std::vector<Stretch>* const left = clipped(pixel);
    if (left) {
      if (left->empty())
        return;
      from = left->front().from;
      to = std::min(to, left->back().to);
    }
    const double length = length_at(pixel);
    surfaces->search_by_ray(
        cell, group, level, cells::RaySpace(ray_of(pixel)), from, to,
        [&](const SurfaceHit& hit) { return take(hit, pixel, hit.t / length, left); }, *counts);
  }

  Ray ray_of(std::int32_t pixel) const {
    return (*rays)(tile.x0 + TileRange::x_of(pixel), tile.y0 + TileRange::y_of(pixel));
  }
  /// How long the pixel's ray is at depth 1.
  double length_at(std::int32_t pixel) const {
    return view.length_at(tile.x0 + TileRange::x_of(pixel), tile.y0 + TileRange::y_of(pixel));
  }

  /// What clips leave of a pixel's ray; null without clips.
  const std::vector<Stretch>* clipped(std::int32_t pixel) {
    if (clips->empty())
      return nullptr;
    clip_ray(*clips, ray_of(pixel), 0, HUGE_VAL, stays);
    return &stays;
  }

  /// Keeps a hit unless it is cut away; whether the ray goes on. left: as clipped() tells.
  bool take(const SurfaceHit& hit, std::int32_t pixel, double depth,
            const std::vector<Stretch>* left) {
    if (left && !stays_at(*left, hit.t))
      return true;
    records.push_back({hit, first[pixel]});
    first[pixel] = std::int32_t(records.size()) - 1;
    if (hit.opacity < 1)
      return true;
    farthest[pixel] = std::min(farthest[pixel], float(depth * (1 + depth_slack)));
    return false;
  }

  /// Appends a pixel's.
  void records_of(int x, int y, std::vector<SurfaceHit>& out) const {
    for (std::int32_t i = first[TileRange::index(x - tile.x0, y - tile.y0)]; i >= 0;
         i = records[std::size_t(i)].next)
      out.push_back(records[std::size_t(i)].hit);
  }
};

IsosurfaceTile::IsosurfaceTile() : work_(std::make_unique<Work>()) {}
IsosurfaceTile::~IsosurfaceTile() = default;

void IsosurfaceTile::trace(const IsosurfaceTracer& surfaces, const RayGenerator& rays,
                           const std::vector<Clip>& clips, int x0, int y0, int x1, int y1,
                           SurfaceCounts& counts) {
  Work& work = *work_;
  work.surfaces = &surfaces;
  work.rays = &rays;
  work.clips = &clips;
  work.counts = &counts;
  work.view = rays.view();
  work.begin(x0, y0, x1, y1);
  accel::for_each_cell_in_frustum(
      surfaces.sampler().tree(), work.view.frustum(x0, y0, x1 - 1, y1 - 1),
      [&](std::uint32_t node) { return surfaces.needed(node); },
      [&](std::int64_t flat) {
        work.add_item(flat);
        return work.look();
      });
  work.flush();
}

void IsosurfaceTile::hits(int x, int y, std::vector<SurfaceHit>& out) {
  work_->records_of(x, y, out);
  work_->surfaces->settle(out, work_->last);
}

void IsosurfaceTile::raw_hits(int x, int y, std::vector<SurfaceHit>& out) {
  const std::size_t before = out.size();
  work_->records_of(x, y, out);
  work_->surfaces->complete(std::span(out).subspan(before), work_->last);
}

} // namespace insitu::render

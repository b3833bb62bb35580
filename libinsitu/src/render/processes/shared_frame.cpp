#include "render/processes/shared_frame.h"

#include <algorithm>
#include <cmath>

#include "accel/tree/tree.h"
#include "render/processes/shown_elsewhere.h"
#include "render/processes/whole_macrocells.h"

namespace insitu::render {

namespace {

/// Rounds of composited samples are longer: what is sent of them hardly grows, and that a ray is
/// saturated is told late.
constexpr int claims_a_round = 4;

bool sends_rays(const Lighting& lighting) {
  return lighting.volume_shadows ||
         (lighting.enabled && (lighting.shadows || lighting.occlusion_samples > 0));
}

} // namespace

SharedFrame::Known::Known(const FramePart& part, const query::Sampler& sampler,
                          const FrameSettings& settings, Structures& structures,
                          const core::Threads& threads) {
  const bool traces = settings.volume && settings.path_tracing;
  if (sends_rays(settings.lighting) || has_central_normals(settings) || traces) {
    std::vector<mesh::Box> boxes;
    query::Directory gathered;
    part.world.agree_after([&] { boxes = query::boxes_of(sampler.tree()); });
    gathered.gather(boxes, part.world);
    part.world.agree_after([&] { where.emplace(gathered, mesh_diagonal(sampler)); });
  }
  if (traces)
    path_majorants = whole_path_majorants(part, sampler, settings, structures, threads);
  else if (settings.volume)
    know_volume(part, sampler, settings, structures);
}

void SharedFrame::Known::know_volume(const FramePart& part, const query::Sampler& sampler,
                                     const FrameSettings& settings, Structures& structures) {
  std::optional<MacrocellGrid> grid;
  if (settings.volume->tolerance) {
    const CellWidths widths = whole_widths(part.world, sampler, structures);
    part.world.agree_after([&] { grid = level_grid(sampler.facts(), widths); });
    macrocells_.emplace(
        whole_macrocells(part.world, sampler, settings.volume->field, *grid, true, structures));
  }
  std::optional<ShownElsewhere> elsewhere;
  part.world.agree_after([&] {
    volume =
        volume_structures(sampler, *settings.volume, std::int64_t(settings.width) * settings.height,
                          structures, grid ? &*grid : nullptr);
    volume.culled = nullptr;
    volume.macrocells = macrocells_ ? &*macrocells_ : nullptr;
    const bool is_of_cells = settings.volume->field.field.association == INSITU_CELL;
    if (part.world.size() == 1 || !(settings.volume->preintegrated || is_of_cells))
      return;
    elsewhere.emplace(sampler.facts().bounds, part.world.size());
    elsewhere->note(sampler.tree(), volume.majorants, ray_step(sampler, *settings.volume));
  });
  if (!elsewhere)
    return;
  elsewhere->exchange(part.world);
  part.world.agree_after([&] {
    if (volume.majorants)
      majorants_ = elsewhere->with(*volume.majorants, structures.memory());
    volume.majorants = majorants_.get();
  });
}

SharedFrame::SharedFrame(const FramePart& part, const query::Sampler& sampler,
                         const FrameSettings& settings, const Known& known, Structures& structures,
                         const core::Threads& threads)
    : part_(part), sampler_(sampler), settings_(settings), threads_(threads),
      rays_(settings.camera, settings.width, settings.height), mail_(part.world, part.most_bytes) {
  const bool traces = settings.volume && settings.path_tracing;
  if (settings.volume && !traces) {
    volume_.emplace(sampler, *settings.volume, known.volume, settings.lighting,
                    !settings.clips.empty());
    volume_->take_part();
    claimed_ = ClaimReader::most_depth / volume_->group() * volume_->group();
    composites_ =
        part.compositing == Compositing::standard && part.world.size() > 1 && !why_exact(settings);
    depth_ = composites_ ? claims_a_round * claimed_ : claimed_;
  }
  if (!settings.isosurfaces.empty() || settings.boundary || !settings.bodies.empty() ||
      settings.outline)
    surfaces_.emplace(sampler, settings, structures, Surfaces::Parts::shared);
  const bool meets = surfaces_ && settings.lighting.volume_shadows;
  if (meets && volume_)
    volume_->set_surfaces(&*surfaces_);
  // Otherwise where two processes claim a sample alone.
  tells_cells_ = settings.cell || (volume_ && (volume_->light_shader() || volume_->has_levels()));
  if (composites_)
    form_ = {surfaces_.has_value(), volume_->is_preintegrated(), volume_->is_lit()};
  if (hits_send_rays() || (volume_ && volume_->light_shader()) || (meets && traces))
    light_.emplace(part, settings, *surfaces_, *known.where, mail_, threads);
  if (has_central_normals(settings))
    normals_.emplace(part, sampler_, *surfaces_, *known.where, mail_, threads);
  if (traces)
    begin_paths(known, meets, structures);
  groups_ = tile_groups(settings.width, settings.height, part.world.size(), tiles_a_group(),
                        traces ? PathTracer::tile_side : FrameTile::marched_side);
}

/// So many that about most_bytes are on their way at a time; with paths, that those of a process's
/// tiles take about as much there.
std::int64_t SharedFrame::tiles_a_group() const {
  const auto most = std::int64_t(part_.most_bytes);
  if (tracer_) {
    const std::int64_t paths = std::int64_t(SharedPaths::bytes_a_tile / sizeof(Path));
    const std::int64_t on_the_way = paths * (bytes_a_path_place + bytes_a_place_value);
    return std::clamp<std::int64_t>(part_.world.size() *
                                        (most / std::int64_t(SharedPaths::bytes_a_tile)),
                                    1, std::max<std::int64_t>(1, most / on_the_way));
  }
  const std::int64_t bytes_a_ray =
      claimed_ * (bytes_a_sample + bytes_a_change + // in any case of some rays
                  (volume_ && volume_->is_lit() ? bytes_a_gradient : 0) +
                  (volume_ && volume_->is_lit_by_place() ? bytes_a_place : 0) +
                  (volume_ && volume_->has_levels() ? bytes_a_level : 0));
  return std::max<std::int64_t>(1, most / (bytes_a_ray * FrameTile::most_rays));
}

void SharedFrame::begin_paths(const Known& known, bool meet_surfaces, Structures& structures) {
  PathTracingSettings tracing = *settings_.path_tracing;
  const PathSums* const sums = tracing.sums;
  tracing.sums = nullptr; // the root adds up
  tracer_.emplace(sampler_, *settings_.volume, tracing, settings_.camera, settings_.lighting.lights,
                  settings_.clips, structures, threads_);
  tracer_->set_samples(tracing.samples, sums ? sums->samples : 0, 1,
                       settings_.depth || settings_.cell);
  if (meet_surfaces)
    tracer_->set_surfaces(&*surfaces_);
  paths_.emplace(part_, settings_, *tracer_, meet_surfaces ? &*surfaces_ : nullptr,
                 meet_surfaces ? &*light_ : nullptr,
                 meet_surfaces && normals_ ? &*normals_ : nullptr, *known.where, mail_, threads_);
}

void SharedFrame::set_sample(const PixelAverage::Sample& sample) {
  sample_ = std::uint64_t(sample.number);
  if (sample.number > 0)
    rays_ = RayGenerator(settings_.camera, settings_.width, settings_.height).shifted(sample.at);
  if (tracer_)
    tracer_->set_samples(sample.paths, sample.first_path, settings_.samples_per_pixel,
                         sample.number == 0 && (settings_.depth || settings_.cell));
}

void SharedFrame::draw(FrameImages& images) {
  for (const std::vector<FrameTile>& group : groups_) {
    group_ = &group;
    find_hits();
    if (paths_)
      trace_paths();
    if (volume_)
      march();
    finish(images);
  }
}

void SharedFrame::add_to(FrameStatistics& statistics) const {
  statistics.add(volume_counts_);
  statistics.add(surface_counts_);
  statistics.hits += hits_;
  if (light_)
    statistics.add(light_->counts());
  statistics.step = volume_ ? volume_->step() : 0.0;
  statistics.unheld = volume_ ? volume_->unheld() : 0;
  statistics.bytes_sent += mail_.bytes_sent();
  statistics.parcels_sent += mail_.parcels_sent();
  statistics.exchanges += mail_.exchanges();
}

void SharedFrame::count(const VolumeCounts& counts) {
  const std::lock_guard lock(mutex_);
  volume_counts_ += counts;
}

void SharedFrame::begin(const FrameTile& tile, std::vector<RayState>& rays) const {
  rays.resize(FrameTile::most_rays); // a ray's vectors keep their memory
  tile.for_each_ray([&](std::size_t ray, int x, int y) {
    RayState& state = rays[ray];
    state.begin(rays_(x, y));
    state.pixel = std::uint64_t(y) * std::uint64_t(settings_.width) + std::uint64_t(x);
    state.sample = sample_;
    if (!settings_.clips.empty())
      clip_ray(settings_.clips, state.ray, 0, HUGE_VAL, state.stays);
  });
}

/// Which tiles of the group are this process's, and in which its cells may be seen.
void SharedFrame::begin_group() {
  own_count_ = near_count_ = 0;
  const accel::Tree& tree = sampler_.tree();
  const ViewSpace view = rays_.view();
  for (std::uint32_t slot = 0; slot < group_->size(); ++slot) {
    const FrameTile& tile = tile_of(slot);
    if (tile.owner == part_.world.rank()) {
      if (own_.size() == own_count_)
        own_.emplace_back();
      OwnTile& own = own_[own_count_++];
      own.slot = slot;
      own.sources.clear();
    }
    if (!tree.empty() && may_meet(view.frustum(tile.x0, tile.y0, tile.x1 - 1, tile.y1 - 1),
                                  tree.bounds_min(), tree.bounds_max())) {
      if (near_.size() == near_count_)
        near_.emplace_back();
      near_[near_count_++].slot = slot;
    }
  }
}

SharedFrame::OwnTile& SharedFrame::own_of(std::uint32_t slot) {
  return *std::find_if(own_.begin(), own_.begin() + std::ptrdiff_t(own_count_),
                       [&](const OwnTile& tile) { return tile.slot == slot; });
}
SharedFrame::NearTile& SharedFrame::near_of(std::uint32_t slot) {
  return *std::find_if(near_.begin(), near_.begin() + std::ptrdiff_t(near_count_),
                       [&](const NearTile& tile) { return tile.slot == slot; });
}

/// All processes find hits in their cells, and say by that where their cells may be seen; owners
/// shade what is seen.
void SharedFrame::find_hits() {
  std::vector<TileParcel> parcels;
  part_.world.agree_after([&] {
    begin_group();
    for_tiles(near_count_, [&](std::size_t i) { find_own_hits(near_[i]); });
    for_tiles(own_count_, [&](std::size_t i) { begin(tile_of(own_[i].slot), own_[i].rays); });
  });
  if (normals_)
    normals_->find(near_count_, [&](std::size_t i) { return rays_of(near_[i]); });
  part_.world.agree_after([&] {
    parcels.resize(near_count_);
    for_tiles(near_count_, [&](std::size_t i) { parcels[i] = take_own_hits(near_[i]); });
  });
  mail_.exchange_in_turns(std::move(parcels), [&](const std::vector<TileParcel>& received) {
    for (const TileParcel& parcel : received) {
      OwnTile& tile = own_of(parcel.slot);
      tile.sources.push_back(parcel.rank);
      read_hits(parcel.reader(), hits_send_rays(), parcel.rank, {}, tile.rays);
    }
  });
  part_.world.agree_after([&] { for_tiles(own_count_, [&](std::size_t i) { order(own_[i]); }); });
  if (hits_send_rays())
    light_hits();
}

void SharedFrame::find_own_hits(NearTile& near) {
  const FrameTile& tile = tile_of(near.slot);
  begin(tile, near.rays);
  if (!surfaces_)
    return;
  thread_local IsosurfaceTile search; // for the thread's life
  SurfaceCounts counts;
  const std::span<RayState> rays = rays_of(near);
  if (const IsosurfaceTracer* const tiled = surfaces_->tiled()) {
    search.trace(*tiled, rays_, settings_.clips, tile.x0, tile.y0, tile.x1, tile.y1, counts);
    surfaces_->find_own(rays, &search, counts);
  } else {
    surfaces_->find_own(rays, nullptr, counts);
  }
  const std::lock_guard lock(mutex_);
  surface_counts_ += counts;
}

/// The hits that a tile's owner gets.
TileParcel SharedFrame::take_own_hits(NearTile& near) {
  thread_local ByteWriter writer; // for the thread's life
  writer.clear();
  const std::span<RayState> rays = rays_of(near);
  write_hits(rays, part_.key, hits_send_rays(), writer);
  for (RayState& ray : rays)
    ray.hits.clear();
  return {tile_of(near.slot).owner, near.slot, writer.bytes()};
}

/// Puts hits in order, and lights them if that takes no rays.
void SharedFrame::order(OwnTile& tile) {
  SurfaceCounts counts;
  const std::span<RayState> rays = rays_of(tile);
  if (!surfaces_)
    return;
  surfaces_->put_in_order(rays);
  if (!hits_send_rays())
    surfaces_->finish(rays, counts);
  std::int64_t hits = 0;
  for (const RayState& ray : rays)
    hits += std::int64_t(ray.hits.size());
  const std::lock_guard lock(mutex_);
  hits_ += hits;
  surface_counts_ += counts;
}

void SharedFrame::trace_paths() {
  std::vector<SharedPaths::Tile> tiles;
  part_.world.agree_after([&] {
    tiles.resize(own_count_);
    for (std::size_t i = 0; i < own_count_; ++i) {
      tiles[i].slot = own_[i].slot;
      for (const FrameTile::Part& part : tile_of(own_[i].slot).parts())
        tiles[i].parts.push_back(rays_of(own_[i]).subspan(part.first_ray, part.rays()));
    }
  });
  paths_->trace(tiles);
}

} // namespace insitu::render

#include "render/processes/shared_frame.h"

#include <algorithm>
#include <cmath>

#include "accel/tree/tree.h"
#include "render/processes/shown_elsewhere.h"

namespace insitu::render {

namespace {

bool sends_rays(const Lighting& lighting) {
  return lighting.volume_shadows ||
         (lighting.enabled && (lighting.shadows || lighting.occlusion_samples > 0));
}

} // namespace

SharedFrame::Known::Known(const FramePart& part, const query::Sampler& sampler,
                          const FrameSettings& settings, Structures& structures) {
  if (sends_rays(settings.lighting)) {
    std::vector<mesh::Box> boxes;
    part.world.agree_after([&] { boxes = query::boxes_of(sampler.tree()); });
    where.gather(boxes, part.world);
  }
  if (settings.volume)
    know_volume(part, sampler, settings, structures);
}

void SharedFrame::Known::know_volume(const FramePart& part, const query::Sampler& sampler,
                                     const FrameSettings& settings, Structures& structures) {
  std::optional<ShownElsewhere> elsewhere;
  part.world.agree_after([&] {
    volume = volume_structures(sampler, *settings.volume,
                               std::int64_t(settings.width) * settings.height, structures);
    volume.culled = nullptr;
    if (!settings.volume->preintegrated || part.world.size() == 1)
      return;
    elsewhere.emplace(sampler.facts().bounds);
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
  if (settings.volume) {
    volume_.emplace(sampler, *settings.volume, known.volume, settings.lighting,
                    !settings.clips.empty());
    volume_->take_part();
    depth_ = ClaimReader::most_depth / volume_->group() * volume_->group();
  }
  if (!settings.isosurfaces.empty() || settings.boundary || !settings.bodies.empty() ||
      settings.outline)
    surfaces_.emplace(sampler, settings, structures, Surfaces::Parts::shared);
  if (surfaces_ && volume_ && settings.lighting.volume_shadows)
    volume_->set_surfaces(&*surfaces_);
  if (hits_send_rays() || (volume_ && volume_->light_shader()))
    light_.emplace(part, settings, *surfaces_, known.where, mesh_diagonal(sampler), mail_, threads);
  const std::int64_t bytes_a_ray =
      depth_ *
      (bytes_a_sample + bytes_a_change + (volume_ && volume_->is_lit() ? bytes_a_gradient : 0) +
       (volume_ && volume_->is_lit_by_place() ? bytes_a_place : 0));
  const auto most_tiles = std::int64_t(part.most_bytes) / (bytes_a_ray * FrameTile::most_rays);
  groups_ = tile_groups(settings.width, settings.height, part.world.size(),
                        std::max<std::int64_t>(1, most_tiles));
}

void SharedFrame::set_sample(const PixelAverage::Sample& sample) {
  sample_ = std::uint64_t(sample.number);
  if (sample.number > 0)
    rays_ = RayGenerator(settings_.camera, settings_.width, settings_.height).shifted(sample.at);
}

void SharedFrame::draw(FrameImages& images) {
  for (const std::vector<FrameTile>& group : groups_) {
    group_ = &group;
    find_hits();
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
    parcels.resize(near_count_);
    for_tiles(near_count_, [&](std::size_t i) { parcels[i] = find_own_hits(near_[i]); });
    for_tiles(own_count_, [&](std::size_t i) { begin(tile_of(own_[i].slot), own_[i].rays); });
  });
  mail_.exchange_in_turns(std::move(parcels), [&](const std::vector<TileParcel>& received) {
    for (const TileParcel& parcel : received) {
      OwnTile& tile = own_of(parcel.slot);
      tile.sources.push_back(parcel.rank);
      read_hits(parcel.reader(), hits_send_rays(), parcel.rank, tile.rays);
    }
  });
  part_.world.agree_after([&] { for_tiles(own_count_, [&](std::size_t i) { order(own_[i]); }); });
  if (hits_send_rays())
    light_hits();
}

TileParcel SharedFrame::find_own_hits(NearTile& near) {
  const FrameTile& tile = tile_of(near.slot);
  begin(tile, near.rays);
  TileParcel parcel{tile.owner, near.slot, {}};
  if (!surfaces_)
    return parcel;
  thread_local IsosurfaceTile search; // these two for the thread's life
  thread_local ByteWriter writer;
  SurfaceCounts counts;
  const std::span<RayState> rays = rays_of(near);
  if (const IsosurfaceTracer* const tiled = surfaces_->tiled()) {
    search.trace(*tiled, rays_, settings_.clips, tile.x0, tile.y0, tile.x1, tile.y1, counts);
    surfaces_->find_own(rays, &search, counts);
  } else {
    surfaces_->find_own(rays, nullptr, counts);
  }
  writer.clear();
  write_hits(rays, part_.key, hits_send_rays(), writer);
  parcel.bytes = writer.bytes();
  for (RayState& ray : rays)
    ray.hits.clear();
  const std::lock_guard lock(mutex_);
  surface_counts_ += counts;
  return parcel;
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

/// Blends what hits are left and sends the pixels to the root.
void SharedFrame::finish(FrameImages& images) {
  std::vector<TileParcel> parcels;
  part_.world.agree_after([&] {
    parcels.resize(own_count_);
    for_tiles(own_count_, [&](std::size_t i) { parcels[i] = finish(own_[i]); });
  });
  mail_.exchange_in_turns(std::move(parcels), [&](const std::vector<TileParcel>& received) {
    for (const TileParcel& parcel : received) {
      ByteReader reader = parcel.reader();
      tile_of(parcel.slot).for_each_ray([&](std::size_t, int x, int y) {
        float* const pixel = images.color.pixel(x, y);
        for (int c = 0; c < 4; ++c)
          pixel[c] = reader.value<float>();
        const auto at = std::size_t(y) * std::size_t(settings_.width) + std::size_t(x);
        if (settings_.depth) // of the first sample of pixels alone
          if (const auto depth = reader.value<float>(); !images.depth.empty())
            images.depth[at] = depth;
        if (settings_.cell)
          if (const auto cell = reader.value<std::int64_t>(); !images.cell.empty())
            images.cell[at] = cell;
      });
    }
  });
}

TileParcel SharedFrame::finish(OwnTile& tile) {
  thread_local ByteWriter writer; // for the thread's life
  writer.clear();
  VolumeCounts counts;
  const std::span<RayState> rays = rays_of(tile);
  if (volume_)
    volume_->finish(rays, *tile.progress);
  for (RayState& state : rays) {
    while (state.next_hit < state.hits.size() && !state.is_saturated())
      state.blend_next_hit();
    writer.value(state.color.r);
    writer.value(state.color.g);
    writer.value(state.color.b);
    writer.value(state.alpha);
    if (settings_.depth)
      writer.value(float(state.depth));
    if (settings_.cell)
      writer.value(state.depth_cell);
    counts.lit += state.lit;
    counts.integrals += state.integrals;
  }
  count(counts);
  return {0, tile.slot, writer.bytes()};
}

} // namespace insitu::render

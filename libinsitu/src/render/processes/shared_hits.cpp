#include "render/processes/shared_frame.h"
#include "render/surface/surfaces_together.h"

/// The hits with surfaces in a frame of several processes.
namespace insitu::render {

/// All processes find hits in their cells, and say by that where their cells may be seen; owners
/// shade what is seen.
void SharedFrame::find_hits() {
  std::vector<TileParcel> parcels;
  part_.world.agree_after([&] {
    begin_group();
    for (Layer& layer : layers_)
      for_tiles(layer.tiles.near.size(),
                [&](std::size_t i) { find_own_hits(layer, layer.tiles.near[i]); });
    for_tiles(own_count_, [&](std::size_t i) { begin(tile_of(own_[i].slot), own_[i].rays); });
  });
  for (Layer& layer : layers_)
    if (layer.normals)
      layer.normals->find(layer.tiles.near.size(),
                          [&](std::size_t i) { return layer.tiles.rays_of(layer.tiles.near[i]); });
  part_.world.agree_after([&] {
    for (std::size_t l = 0; l < layers_.size(); ++l) {
      const std::span<NearTile> near = layers_[l].tiles.near;
      const std::size_t before = parcels.size();
      parcels.resize(before + near.size());
      for_tiles(near.size(),
                [&](std::size_t i) { parcels[before + i] = take_own_hits(l, near[i]); });
    }
  });
  mail_.exchange_in_turns(std::move(parcels), [&](const std::vector<TileParcel>& received) {
    for (const TileParcel& parcel : received)
      read_own_hits(parcel);
  });
  part_.world.agree_after([&] { for_tiles(own_count_, [&](std::size_t i) { order(own_[i]); }); });
  if (hits_send_rays())
    light_hits();
}

void SharedFrame::find_own_hits(Layer& layer, NearTile& near) {
  const FrameTile& tile = tile_of(near.slot);
  begin(tile, near.rays);
  if (!layer.surfaces)
    return;
  thread_local IsosurfaceTile search; // for the thread's life
  SurfaceCounts counts;
  const std::span<RayState> rays = layer.tiles.rays_of(near);
  if (const IsosurfaceTracer* const tiled = layer.surfaces->tiled()) {
    search.trace(*tiled, rays_, settings_.clips, tile.x0, tile.y0, tile.x1, tile.y1, counts);
    layer.surfaces->find_own(rays, &search, counts);
  } else {
    layer.surfaces->find_own(rays, nullptr, counts);
  }
  const std::lock_guard lock(mutex_);
  surface_counts_ += counts;
}

/// The hits that a tile's owner gets: a parcel about the tile and the layer.
TileParcel SharedFrame::take_own_hits(std::size_t layer, NearTile& near) {
  thread_local ByteWriter writer; // for the thread's life
  writer.clear();
  const std::span<RayState> rays = layers_[layer].tiles.rays_of(near);
  write_hits(rays, layers_[layer].part.key, hits_send_rays(), writer);
  for (RayState& ray : rays)
    ray.hits.clear();
  return {tile_of(near.slot).owner,
          near.slot * std::uint32_t(layers_.size()) + std::uint32_t(layer), writer.bytes()};
}

void SharedFrame::read_own_hits(const TileParcel& parcel) {
  const std::size_t l = parcel.slot % layers_.size();
  const std::uint32_t slot = parcel.slot / std::uint32_t(layers_.size());
  const SharedTiles all{group_, own_tiles(), {}};
  if (layers_[l].volume || layers_.size() == 1)
    layers_[l].tiles.own_of(slot).sources.push_back(parcel.rank);
  read_hits(parcel.reader(), hits_send_rays(), parcel.rank, {}, all.own_of(slot).rays,
            std::int32_t(l));
}

/// Puts hits in order, and lights them if that takes no rays.
void SharedFrame::order(OwnTile& tile) {
  SurfaceCounts counts;
  const std::span<RayState> rays = rays_of(tile);
  if (!first_surfaces_)
    return;
  order_together(surfaces_, rays);
  if (!hits_send_rays()) {
    for (const Layer& layer : layers_)
      if (layer.surfaces)
        layer.surfaces->light(rays, counts);
    for (const Layer& layer : layers_)
      if (layer.surfaces)
        layer.surfaces->add_lines(rays);
  }
  std::int64_t hits = 0;
  for (const RayState& ray : rays)
    hits += std::int64_t(ray.hits.size());
  const std::lock_guard lock(mutex_);
  hits_ += hits;
  surface_counts_ += counts;
}

/// Lights the hits of own tiles by rays that all processes follow.
void SharedFrame::light_hits() {
  std::vector<SharedLight::Seen> seen;
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    if (!layers_[l].surfaces)
      continue;
    part_.world.agree_after([&] {
      seen.assign(own_count_, {});
      for_tiles(own_count_, [&](std::size_t i) {
        seen[i].slot = own_[i].slot;
        layers_[l].surfaces->see(rays_of(own_[i]), seen[i].hits);
      });
    });
    light_->light(l, seen);
  }
  part_.world.agree_after([&] {
    for (const Layer& layer : layers_)
      if (layer.surfaces)
        for_tiles(own_count_, [&](std::size_t i) { layer.surfaces->add_lines(rays_of(own_[i])); });
  });
}

} // namespace insitu::render

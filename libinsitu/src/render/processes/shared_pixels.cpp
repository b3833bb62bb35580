#include "render/processes/shared_frame.h"
#include "render/volume/volumes_together.h"

/// How the pixels of a frame of several processes come to the root.
namespace insitu::render {

/// Blends what hits are left and sends the pixels to the root.
void SharedFrame::finish(FrameImages& images) {
  std::vector<TileParcel> parcels;
  if (settings_.cell && part_.solvers_cell && sample_ == 0)
    find_solvers_cells();
  part_.world.agree_after([&] {
    parcels.resize(own_count_);
    for_tiles(own_count_, [&](std::size_t i) { parcels[i] = finish(i); });
  });
  mail_.exchange_in_turns(std::move(parcels), [&](const std::vector<TileParcel>& received) {
    for (const TileParcel& parcel : received) {
      ByteReader reader = parcel.reader();
      tile_of(parcel.slot).for_each_ray([&](std::size_t, int x, int y) {
        const auto at = std::size_t(y) * std::size_t(settings_.width) + std::size_t(x);
        read_pixel(reader, at, images.color.pixel(x, y));
        if (settings_.depth) // of the first sample of pixels alone
          if (const auto depth = reader.value<float>(); !images.depth.empty())
            images.depth[at] = depth;
        if (settings_.cell)
          if (const auto cell = reader.value<std::int64_t>(); !images.cell.empty())
            images.cell[at] = cell;
        if (settings_.cell && layers_.size() > 1)
          if (const auto layer = reader.value<std::int32_t>(); !images.layer.empty())
            images.layer[at] = layer;
      });
    }
  });
}

/// Gathers what is left of the rays; again, nothing, unless there are several volumes.
void SharedFrame::complete(std::size_t own) {
  thread_local std::vector<LayerStretches> stretches; // for the thread's life
  const std::span<RayState> rays = rays_of(own_[own]);
  for (Layer& layer : layers_)
    if (layer.volume) {
      OwnTile& tile = layer.tiles.own[own];
      layer.volume->marcher().finish(layer.tiles.rays_of(tile), *tile.progress);
    }
  for (std::size_t r = 0; r < rays.size() && volumes_ > 1; ++r) {
    stretches.clear();
    for (std::size_t l = 0; l < layers_.size(); ++l)
      if (layers_[l].volume)
        stretches.push_back({layers_[l].alone[own].rays[r].stretches, std::int32_t(l)});
    blend_together(rays[r], stretches);
  }
  for (RayState& state : rays)
    while (state.next_hit < state.hits.size() && !state.is_saturated())
      state.blend_next_hit();
}

TileParcel SharedFrame::finish(std::size_t own) {
  thread_local ByteWriter writer; // for the thread's life
  writer.clear();
  VolumeCounts counts;
  OwnTile& tile = own_[own];
  complete(own);
  const std::span<RayState> rays = rays_of(tile);
  for (std::size_t r = 0; r < rays.size(); ++r) {
    const RayState& state = rays[r];
    write_pixel(own, r, writer);
    if (settings_.depth)
      writer.value(float(state.depth));
    if (settings_.cell)
      writer.value(state.depth_cell);
    if (settings_.cell && layers_.size() > 1)
      writer.value(state.depth_layer);
    for (const Layer& layer : layers_)
      if (layer.volume) {
        const RayState& gathered = layer.tiles.own[own].rays[r];
        counts.lit += gathered.lit;
        counts.integrals += gathered.integrals;
      }
  }
  count(counts);
  return {0, tile.slot, writer.bytes()};
}

/// Whether the root adds up the samples of paths of frames before.
bool SharedFrame::adds_up() const {
  return paths_ && settings_.path_tracing->sums && settings_.samples_per_pixel == 1;
}

/// Colour and alpha; or, to be added up, whether there are sums of samples, and these.
void SharedFrame::write_pixel(std::size_t own, std::size_t ray, ByteWriter& to) const {
  const PathSums::Pixel* sum = nullptr;
  if (adds_up()) {
    sum = paths_->sum(own, ray);
    to.value(std::uint8_t(sum != nullptr));
  }
  if (sum) {
    to.value(*sum);
    return;
  }
  const RayState& state = own_[own].rays[ray];
  to.value(state.color.r);
  to.value(state.color.g);
  to.value(state.color.b);
  to.value(state.alpha);
}

void SharedFrame::read_pixel(ByteReader& from, std::size_t at, float* pixel) const {
  if (!adds_up() || !from.value<std::uint8_t>()) {
    for (int c = 0; c < 4; ++c)
      pixel[c] = from.value<float>();
    return;
  }
  PathSums& sums = *settings_.path_tracing->sums;
  const PathSums::Pixel sum = sums.add(at, from.value<PathSums::Pixel>());
  const auto samples = double(sums.samples + settings_.path_tracing->samples);
  const double means[4] = {sum.r / samples, sum.g / samples, sum.b / samples, sum.alpha / samples};
  for (int c = 0; c < 4; ++c)
    pixel[c] = float(means[c]);
}

} // namespace insitu::render

#include "render/processes/shared_frame.h"

#include <algorithm>
#include <cmath>

#include "accel/tree/tree.h"
#include "render/processes/shown_elsewhere.h"
#include "render/processes/whole_macrocells.h"
#include "render/volume/volumes_together.h"

namespace insitu::render {

namespace {

bool sends_rays(const Lighting& lighting) {
  return lighting.volume_shadows ||
         (lighting.enabled && (lighting.shadows || lighting.occlusion_samples > 0));
}

bool traces(const FrameSettings& settings) {
  return settings.volume && settings.path_tracing;
}

} // namespace

SharedFrame::Known::Known(const FramePart& part, const FrameLayer& layer,
                          const core::Threads& threads) {
  const auto& [sampler, settings, structures] = layer;
  if (sends_rays(settings.lighting) || has_central_normals(settings) || traces(settings)) {
    std::vector<mesh::Box> boxes;
    query::Directory gathered;
    part.world.agree_after([&] { boxes = query::boxes_of(sampler.tree()); });
    gathered.gather(boxes, part.world);
    part.world.agree_after([&] { where.emplace(gathered, mesh_diagonal(sampler)); });
  }
  if (traces(settings))
    path_majorants = whole_path_majorants(part, sampler, settings, structures, threads);
  else if (settings.volume)
    know_volume(part, layer);
}

void SharedFrame::Known::know_volume(const FramePart& part, const FrameLayer& layer) {
  const auto& [sampler, settings, structures] = layer;
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

SharedFrame::SharedFrame(std::span<const FramePart> parts, std::span<const FrameLayer> layers,
                         std::span<const std::optional<Known>> known, const core::Threads& threads)
    : part_(parts[0]), settings_(layers[0].settings), threads_(threads),
      rays_(settings_.camera, settings_.width, settings_.height),
      mail_(part_.world, part_.most_bytes) {
  for (std::size_t l = 0; l < layers.size(); ++l) {
    layers_.emplace_back(parts[l], layers[l]);
    if (!layers[l].settings.volume || traces(layers[l].settings))
      continue;
    ++volumes_;
    volume_layer_ = std::int32_t(l);
  }
  begin_surfaces(layers);
  begin_light(known);
  begin_volumes(layers, known);
  if (std::any_of(layers.begin(), layers.end(),
                  [](const FrameLayer& layer) { return traces(layer.settings); }))
    begin_paths(layers, known);
  const bool by_paths = tracer_ || volumes_ > 1; // so many rays together as one process takes
  groups_ = tile_groups(settings_.width, settings_.height, part_.world.size(), tiles_a_group(),
                        by_paths ? PathTracer::tile_side : FrameTile::marched_side);
}

void SharedFrame::begin_surfaces(std::span<const FrameLayer> layers) {
  const bool shadows_others =
      settings_.lighting.volume_shadows &&
      std::any_of(layers.begin(), layers.end(),
                  [](const FrameLayer& layer) { return has_surfaces(layer.settings); });
  for (std::size_t l = 0; l < layers.size(); ++l) {
    Layer& layer = layers_[l];
    surfaces_.push_back(nullptr);
    if (!has_surfaces(layer.settings) && !(layer.settings.volume && shadows_others))
      continue;
    layer.surfaces.emplace(layer.sampler, layer.settings, layers[l].structures,
                           Surfaces::Parts::shared);
    layer.surfaces->join(std::int32_t(l), {}); // what rays of light meet is asked for
    surfaces_.back() = &*layer.surfaces;
    if (first_surfaces_)
      continue;
    first_surfaces_ = &*layer.surfaces;
    first_surfaced_ = l;
  }
}

void SharedFrame::begin_light(std::span<const std::optional<Known>> known) {
  std::vector<SharedLight::Layer> lit;
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    Layer& layer = layers_[l];
    const CellBoxes* const where = known[l]->where ? &*known[l]->where : nullptr;
    lit.push_back(
        {&layer.part, &layer.settings, layer.surfaces ? &*layer.surfaces : nullptr, where});
    if (has_central_normals(layer.settings))
      layer.normals.emplace(layer.part, layer.sampler, *layer.surfaces, *where, mail_, threads_);
  }
  if (first_surfaces_ && sends_rays(settings_.lighting))
    light_.emplace(std::move(lit), mail_, threads_);
}

void SharedFrame::begin_volumes(std::span<const FrameLayer> layers,
                                std::span<const std::optional<Known>> known) {
  std::vector<const FrameSettings*> settings;
  for (const FrameLayer& layer : layers)
    settings.push_back(&layer.settings);
  SharedVolume::Beside beside;
  beside.has_surfaces = first_surfaces_ != nullptr;
  if (first_surfaces_ && settings_.lighting.volume_shadows)
    beside.shadows = first_surfaces_;
  beside.light = light_ ? &*light_ : nullptr;
  beside.light_first = first_surfaced_;
  beside.is_exact = part_.compositing == Compositing::exact || part_.world.size() == 1 ||
                    why_exact(settings) != nullptr;
  for (std::size_t l = 0; l < layers.size(); ++l)
    if (Layer& layer = layers_[l]; layer.settings.volume && !traces(layer.settings))
      layer.volume.emplace(layer.part, layer.sampler, layer.settings, known[l]->volume, beside,
                           mail_, threads_);
}

/// So many that about most_bytes are on their way at a time; with paths, that those of a process's
/// tiles take about as much there, and so with stretches of several volumes, where a process has
/// one tile at least.
std::int64_t SharedFrame::tiles_a_group() const {
  const auto most = std::int64_t(part_.most_bytes), processes = std::int64_t(part_.world.size());
  if (tracer_) {
    const std::int64_t paths = std::int64_t(SharedPaths::bytes_a_tile / sizeof(Path));
    const std::int64_t on_the_way = paths * (bytes_a_path_place + bytes_a_place_value);
    return std::clamp<std::int64_t>(processes * (most / std::int64_t(SharedPaths::bytes_a_tile)), 1,
                                    std::max<std::int64_t>(1, most / on_the_way));
  }
  std::int64_t bytes_a_ray =
      volumes_ > 0 ? 0 : ClaimReader::most_depth * (bytes_a_sample + bytes_a_change);
  double kept = 0; // bytes of a ray's stretches, of all volumes
  for (const Layer& layer : layers_)
    if (layer.volume) {
      bytes_a_ray = std::max(bytes_a_ray, layer.volume->bytes_a_ray());
      kept += sizeof(RayState) +
              sizeof(VolumeStretch) * mesh_diagonal(layer.sampler) / layer.volume->marcher().step();
    }
  const auto at_most = std::max<std::int64_t>(1, most / (bytes_a_ray * FrameTile::most_rays));
  if (volumes_ < 2)
    return at_most;
  const auto owned = std::int64_t(double(most) / (kept * FrameTile::most_rays));
  return std::min(at_most, processes * std::max<std::int64_t>(1, owned));
}

void SharedFrame::begin_paths(std::span<const FrameLayer> layers,
                              std::span<const std::optional<Known>> known) {
  PathTracingSettings tracing = *settings_.path_tracing;
  const PathSums* const sums = tracing.sums;
  tracing.sums = nullptr; // the root adds up
  tracer_.emplace(tracing, settings_.camera, settings_.lighting.lights, settings_.clips);
  tracer_->set_samples(tracing.samples, sums ? sums->samples : 0, 1,
                       settings_.depth || settings_.cell);
  for (std::size_t l = 0; l < layers.size(); ++l)
    if (traces(layers[l].settings))
      tracer_->add(layers[l].sampler, *layers[l].settings.volume, *known[l]->path_majorants,
                   threads_, layers[l].structures.memory(), std::int32_t(l));
  const bool meets = first_surfaces_ && settings_.lighting.volume_shadows;
  if (meets)
    tracer_->set_surfaces(first_surfaces_);
  std::vector<SharedPaths::Layer> met;
  const Medium* medium = tracer_->media().data();
  for (std::size_t l = 0; l < layers_.size(); ++l) {
    const Layer& layer = layers_[l];
    met.push_back({&layer.part, known[l]->where ? &*known[l]->where : nullptr,
                   traces(layer.settings) ? medium++ : nullptr, meets ? surfaces_[l] : nullptr,
                   meets && layer.normals ? &*layer.normals : nullptr});
  }
  paths_.emplace(std::move(met), first_surfaced_, settings_, *tracer_, meets ? &*light_ : nullptr,
                 mail_, threads_);
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
  statistics.step = 0;
  statistics.unheld = 0;
  for (const Layer& layer : layers_)
    if (layer.volume) {
      const double step = layer.volume->marcher().step();
      statistics.add(layer.volume->counts());
      statistics.step = statistics.step > 0 ? std::min(statistics.step, step) : step;
      statistics.unheld += layer.volume->marcher().unheld();
    }
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
    state.volume_layer = volume_layer_;
    if (!settings_.clips.empty())
      clip_ray(settings_.clips, state.ray, 0, HUGE_VAL, state.stays);
  });
}

/// Which tiles of the group are this process's, and in which its cells may be seen.
void SharedFrame::begin_group() {
  own_count_ = 0;
  for (std::uint32_t slot = 0; slot < group_->size(); ++slot)
    if (tile_of(slot).owner == part_.world.rank()) {
      if (own_.size() == own_count_)
        own_.emplace_back();
      OwnTile& own = own_[own_count_++];
      own.slot = slot;
      own.sources.clear();
    }
  for (Layer& layer : layers_)
    begin_group(layer);
}

void SharedFrame::begin_group(Layer& layer) {
  const accel::Tree& tree = layer.sampler.tree();
  const ViewSpace view = rays_.view();
  std::size_t near_count = 0;
  for (std::uint32_t slot = 0; slot < group_->size(); ++slot) {
    const FrameTile& tile = tile_of(slot);
    if (!tree.empty() && may_meet(view.frustum(tile.x0, tile.y0, tile.x1 - 1, tile.y1 - 1),
                                  tree.bounds_min(), tree.bounds_max())) {
      if (layer.near.size() == near_count)
        layer.near.emplace_back();
      layer.near[near_count++].slot = slot;
    }
  }
  layer.tiles = {group_, own_tiles(), {layer.near.data(), near_count}};
  if (volumes_ < 2 || !layer.volume)
    return;
  if (layer.alone.size() < own_count_)
    layer.alone.resize(own_count_);
  layer.tiles.own = {layer.alone.data(), own_count_};
  for (std::size_t i = 0; i < own_count_; ++i) {
    layer.alone[i].slot = own_[i].slot;
    layer.alone[i].sources.clear();
  }
}

/// Volumes one after the other: one with the hits of all meshes, or each alone, to be blended when
/// the pixels are finished.
void SharedFrame::march() {
  if (volumes_ > 1)
    part_.world.agree_after([&] {
      for (Layer& layer : layers_)
        if (layer.volume)
          for_tiles(own_count_, [&](std::size_t i) {
            const std::span<RayState> rays = rays_of(own_[i]);
            layer.alone[i].rays.resize(FrameTile::most_rays);
            for (std::size_t r = 0; r < rays.size(); ++r)
              begin_alone(layer.alone[i].rays[r], rays[r]);
          });
    });
  for (Layer& layer : layers_)
    if (layer.volume)
      layer.volume->march(layer.tiles);
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

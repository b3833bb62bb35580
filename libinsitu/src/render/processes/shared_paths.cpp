#include "render/processes/shared_paths.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/for_each.h"
#include "render/path/path_grid.h"
#include "render/processes/shared_light_data.h"
#include "render/processes/whole_macrocells.h"
#include "render/surface/surfaces_together.h"

namespace insitu::render {

using math::Vec3d;

namespace {

/// What a parcel of questions begins with: how many there are.
struct Head {
  std::uint32_t values, lights, walls;
};
static_assert(sizeof(Head) == std::size_t(bytes_a_path_head));

struct SentRay {
  Vec3d origin, direction;
  double t_max;
};
static_assert(sizeof(SentRay) == std::size_t(bytes_a_path_ray));
static_assert(sizeof(Vec3d) == std::size_t(bytes_a_path_place));

} // namespace

std::unique_ptr<Majorants> whole_path_majorants(const FramePart& part,
                                                const query::Sampler& sampler,
                                                const FrameSettings& settings,
                                                Structures& structures,
                                                const core::Threads& threads) {
  const VolumeSettings& volume = *settings.volume;
  const CellWidths widths = whole_widths(part.world, sampler, structures);
  MacrocellGrid grid;
  part.world.agree_after([&] {
    grid = path_grid(sampler.facts(), widths, settings.path_tracing->cells_per_macrocell);
  });
  const Macrocells whole =
      whole_macrocells(part.world, sampler, volume.field, grid, false, structures);
  std::unique_ptr<Majorants> majorants;
  part.world.agree_after([&] {
    majorants = std::make_unique<Majorants>(whole, volume.function, threads, structures.memory());
  });
  return majorants;
}

SharedPaths::SharedPaths(std::vector<Layer> layers, std::size_t first,
                         const FrameSettings& settings, const PathTracer& tracer,
                         SharedLight* light, TileMail& mail, const core::Threads& threads)
    : layers_(std::move(layers)), first_(first), world_(layers_[0].part->world),
      settings_(settings), tracer_(tracer), light_(light), mail_(mail), threads_(threads) {
  for (const Layer& layer : layers_) {
    surfaces_.push_back(layer.surfaces);
    if (layer.medium)
      media_.push_back(layer.medium);
  }
}

void SharedPaths::trace(std::span<const Tile> tiles) {
  std::vector<std::pair<std::size_t, std::size_t>> waves; // by tile and part
  world_.agree_after([&] {
    count_ = tiles.size();
    if (batches_.size() < count_)
      batches_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      Batch& batch = batches_[i];
      batch.slot = tiles[i].slot;
      batch.parts = tiles[i].parts.size();
      if (batch.waves.size() < batch.parts)
        batch.waves.resize(batch.parts);
      batch.asked.resize(layers_.size() * std::size_t(world_.size()));
      for (std::size_t p = 0; p < batch.parts; ++p)
        waves.emplace_back(i, p);
    }
    core::for_each(threads_, waves.size(), [&](std::size_t w) {
      const auto [i, p] = waves[w];
      batches_[i].waves[p].begin(tracer_, tiles[i].parts[p]);
    });
  });
  for (;;) {
    std::int64_t waiting = 0;
    world_.agree_after([&] {
      for (std::size_t i = 0; i < count_; ++i)
        waiting += collect(batches_[i]);
    });
    world_.reduce(std::span(&waiting, 1), parallel::Reduction::greatest);
    if (waiting == 0)
      break;
    std::vector<TileParcel> parcels;
    world_.agree_after([&] {
      std::vector<std::vector<TileParcel>> of(count_);
      core::for_each(threads_, count_, [&](std::size_t i) { ask(batches_[i], of[i]); });
      for (std::vector<TileParcel>& some : of)
        std::move(some.begin(), some.end(), std::back_inserter(parcels));
    });
    const std::vector<TileParcel> questions = mail_.exchange(std::move(parcels));
    std::vector<TileParcel> answers;
    std::vector<WallRays> walls; // by question
    world_.agree_after([&] {
      walls.resize(questions.size());
      if (light_)
        core::for_each(threads_, questions.size(),
                       [&](std::size_t q) { walls[q] = find_walls(questions[q]); });
    });
    for (std::size_t l = 0; l < layers_.size(); ++l)
      if (layers_[l].normals)
        layers_[l].normals->find(walls.size(), [&](std::size_t q) {
          return layer_of(questions[q].slot) == l ? std::span(walls[q]) : std::span<RayState>();
        });
    world_.agree_after([&] {
      answers.resize(questions.size());
      core::for_each(threads_, questions.size(), [&](std::size_t q) {
        answers[q] = {questions[q].rank, questions[q].slot, answer(questions[q], walls[q])};
      });
    });
    const std::vector<TileParcel> received = mail_.exchange(std::move(answers));
    world_.agree_after([&] {
      core::for_each(threads_, count_, [&](std::size_t i) { take(batches_[i], received); });
    });
    if (light_)
      light_walls();
    world_.agree_after([&] {
      core::for_each(threads_, waves.size(), [&](std::size_t w) {
        const auto [i, p] = waves[w];
        batches_[i].waves[p].go_on();
      });
    });
  }
  world_.agree_after([&] {
    for (const auto& [i, p] : waves) {
      batches_[i].waves[p].store();
      counts_ += batches_[i].waves[p].counts();
    }
  });
}

const PathSums::Pixel* SharedPaths::sum(std::size_t tile, std::size_t ray) const {
  std::size_t part = 0;
  while (ray >= batches_[tile].waves[part].rays())
    ray -= batches_[tile].waves[part++].rays();
  return batches_[tile].waves[part].sum(ray);
}

/// Sets what a batch's paths ask, and returns how many do.
std::int64_t SharedPaths::collect(Batch& batch) const {
  batch.values.clear();
  batch.lights.clear();
  batch.walls.clear();
  for (std::size_t p = 0; p < batch.parts; ++p)
    for (Path& path : batch.waves[p].waiting())
      (path.asks == Path::Asks::value   ? batch.values
       : path.asks == Path::Asks::light ? batch.lights
                                        : batch.walls)
          .push_back(&path);
  return std::int64_t(batch.values.size() + batch.lights.size() + batch.walls.size());
}

/// Adds a batch's questions to those processes whose cells may know.
void SharedPaths::ask(Batch& batch, std::vector<TileParcel>& parcels) const {
  for (std::size_t l = 0; l < layers_.size(); ++l)
    for (int process = 0; process < world_.size(); ++process)
      ask(batch, l, process, parcels);
}

void SharedPaths::ask(Batch& batch, std::size_t l, int process,
                      std::vector<TileParcel>& parcels) const {
  thread_local ByteWriter writer; // for the thread's life
  const Layer& layer = layers_[l];
  Asked& asked = asked_of(batch, l, process);
  const auto pick = [](const std::vector<Path*>& paths, std::vector<std::uint32_t>& picked,
                       const auto& may_know) {
    picked.clear();
    for (std::size_t i = 0; i < paths.size(); ++i)
      if (may_know(*paths[i]))
        picked.push_back(std::uint32_t(i));
  };
  const auto may_meet = [&](const Path& path, double far) {
    return layer.surfaces && layer.where->may_meet(process, path.ray, far);
  };
  pick(batch.values, asked.values, [&](const Path& path) {
    return media_[path.medium] == layer.medium && layer.where->may_hold(process, path.place());
  });
  pick(batch.lights, asked.lights, [&](const Path& path) { return may_meet(path, path.far); });
  pick(batch.walls, asked.walls, [&](const Path& path) { return may_meet(path, HUGE_VAL); });
  if (asked.values.empty() && asked.lights.empty() && asked.walls.empty())
    return;
  writer.clear();
  writer.value(Head{std::uint32_t(asked.values.size()), std::uint32_t(asked.lights.size()),
                    std::uint32_t(asked.walls.size())});
  for (const std::uint32_t i : asked.values)
    writer.value(batch.values[i]->place());
  for (const std::uint32_t i : asked.lights) {
    const Path& path = *batch.lights[i];
    writer.value(SentRay{path.ray.origin, path.ray.direction, path.far});
  }
  for (const std::uint32_t i : asked.walls) {
    const Path& path = *batch.walls[i];
    writer.value(SentRay{path.ray.origin, path.ray.direction, HUGE_VAL});
  }
  parcels.push_back({process, slot_of(batch.slot, l), writer.bytes()});
}

namespace {

SharedLight::Rays::One light_ray(const Ray& ray, double t_max, std::size_t point) {
  return {ray, t_max, std::uint32_t(point)};
}

} // namespace

std::vector<std::byte> SharedPaths::answer(const TileParcel& asked, const WallRays& walls) const {
  thread_local ByteWriter writer; // for the thread's life
  writer.clear();
  const std::size_t l = layer_of(asked.slot);
  const Layer& layer = layers_[l];
  ByteReader reader = asked.reader();
  const auto head = reader.value<Head>();
  answer_values(layer, reader, head.values, writer);
  if (!layer.surfaces)
    return writer.bytes();
  std::vector<SharedLight::Rays::One> rays;
  for (std::size_t i = 0; i < head.lights; ++i) {
    const auto sent = reader.value<SentRay>();
    rays.push_back(light_ray({sent.origin, sent.direction}, sent.t_max, i));
  }
  SurfaceCounts none; // as of one process, which does not count them either
  light_->write_met(l, SharedLight::Rays(std::move(rays)), {}, none, writer);
  write_hits(walls, layer.part->key, layer.surfaces->light_shader(), writer);
  return writer.bytes();
}

/// The hits of scattered light in this process's cells.
SharedPaths::WallRays SharedPaths::find_walls(const TileParcel& asked) const {
  const Surfaces* const surfaces = surfaces_[layer_of(asked.slot)];
  ByteReader reader = asked.reader();
  const auto head = reader.value<Head>();
  WallRays rays(head.walls);
  if (!surfaces)
    return rays;
  reader.skip<Vec3d>(head.values);
  reader.skip<SentRay>(head.lights);
  for (RayState& ray : rays) {
    const auto sent = reader.value<SentRay>();
    ray.begin({sent.origin, sent.direction});
    clip_ray(settings_.clips, ray.ray, 0, HUGE_VAL, ray.stays);
  }
  SurfaceCounts none;
  surfaces->find_own(rays, nullptr, none);
  return rays;
}

/// The values at places that cells of this process hold.
void SharedPaths::answer_values(const Layer& layer, ByteReader& from, std::size_t count,
                                ByteWriter& to) {
  const auto places = from.array<Vec3d>(count);
  std::vector<PlaceValue> found(count);
  if (count > 0)
    layer.medium->find_values(places, found);
  for (PlaceValue& value : found)
    value.cell = layer.part->own_key(layer.medium->mesh(), value.cell);
  write_values(found, to);
}

/// Nothing is known yet.
void SharedPaths::begin_answers(Batch& batch) const {
  for (Path* path : batch.values)
    path->found = {};
  for (Path* path : batch.lights)
    path->open = 1;
  if (batch.wall_rays.size() < batch.walls.size())
    batch.wall_rays.resize(batch.walls.size());
  for (std::size_t i = 0; i < batch.walls.size(); ++i) {
    RayState& state = batch.wall_rays[i];
    state.begin(batch.walls[i]->ray);
    clip_ray(settings_.clips, state.ray, 0, HUGE_VAL, state.stays);
  }
}

/// Puts the answers about a batch together: of light, what comes through each mesh is a factor.
void SharedPaths::take(Batch& batch, std::span<const TileParcel> answers) const {
  begin_answers(batch);
  std::vector<SharedLight::Rays::One> sent;
  for (std::size_t i = 0; i < batch.lights.size(); ++i)
    sent.push_back(light_ray(batch.lights[i]->ray, batch.lights[i]->far, i));
  const SharedLight::Rays rays(std::move(sent));
  const auto take_layer = [&](std::size_t l) {
    std::vector<double> open(batch.lights.size(), 1.0);
    SharedLight::Met met;
    for (const TileParcel& parcel : answers) {
      if (parcel.slot != slot_of(batch.slot, l))
        continue;
      const Asked& asked = asked_of(batch, l, parcel.rank);
      ByteReader reader = parcel.reader();
      read_values(reader, asked.values,
                  [&](std::uint32_t i) -> PlaceValue& { return batch.values[i]->found; });
      if (!surfaces_[l])
        continue;
      SharedLight::read_met(reader, rays, asked.lights, open, met);
      read_hits(reader, surfaces_[l]->light_shader(), parcel.rank, asked.walls, batch.wall_rays,
                std::int32_t(l));
    }
    if (!surfaces_[l])
      return;
    light_->pass(l, rays, met, open);
    for (std::size_t i = 0; i < batch.lights.size(); ++i)
      batch.lights[i]->open *= open[i];
  };
  take_layer(first_);
  for (std::size_t l = 0; l < layers_.size(); ++l)
    if (l != first_)
      take_layer(l);
  if (light_)
    take_walls(batch);
}

/// At which of the hits scattered light ends: it alone stays.
void SharedPaths::take_walls(Batch& batch) const {
  const std::span<RayState> rays(batch.wall_rays.data(), batch.walls.size());
  order_together(surfaces_, rays);
  for (std::size_t i = 0; i < rays.size(); ++i) {
    Path& path = *batch.walls[i];
    std::vector<SurfaceHit>& hits = rays[i].hits;
    const auto end = std::find_if(hits.begin(), hits.end(), [&](const SurfaceHit& hit) {
      return hit.opacity >= 1 || path.ends_at(hit.opacity);
    });
    path.wall = HUGE_VAL;
    if (end == hits.end()) {
      hits.clear();
      continue;
    }
    std::swap(hits.front(), *end);
    hits.resize(1);
    path.wall = hits.front().t;
    surfaces_[std::size_t(hits.front().layer)]->set_color(hits.front());
  }
}

/// Lights the surfaces at which scattered light ends.
void SharedPaths::light_walls() {
  for (std::size_t l = 0; l < layers_.size(); ++l)
    if (surfaces_[l])
      light_walls(l);
  world_.agree_after([&] {
    for (std::size_t b = 0; b < count_; ++b)
      for (std::size_t i = 0; i < batches_[b].walls.size(); ++i)
        if (const auto& hits = batches_[b].wall_rays[i].hits; !hits.empty())
          batches_[b].walls[i]->wall_color = hits.front().color;
  });
}

void SharedPaths::light_walls(std::size_t layer) {
  const Surfaces& surfaces = *surfaces_[layer];
  std::vector<SharedLight::Seen> seen;
  world_.agree_after([&] {
    seen.resize(count_);
    for (std::size_t b = 0; b < count_; ++b) {
      Batch& batch = batches_[b];
      seen[b].slot = batch.slot;
      for (std::size_t i = 0; i < batch.walls.size(); ++i)
        if (RayState& state = batch.wall_rays[i];
            !state.hits.empty() && state.hits.front().layer == std::int32_t(layer))
          seen[b].hits.push_back({&state.ray, batch.walls[i]->seed, state.hits.data()});
    }
    SurfaceCounts none;
    if (surfaces.lights_hits() && !surfaces.light_shader())
      for (const SharedLight::Seen& of_tile : seen)
        surfaces.light(of_tile.hits, none);
  });
  if (surfaces.light_shader())
    light_->light(layer, seen);
}

} // namespace insitu::render

#include "render/processes/shared_paths.h"

#include <algorithm>
#include <iterator>

#include "core/for_each.h"
#include "render/path/path_grid.h"
#include "render/processes/shared_light_data.h"
#include "render/processes/whole_macrocells.h"

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

SharedPaths::SharedPaths(const FramePart& part, const FrameSettings& settings,
                         const PathTracer& tracer, const Surfaces* surfaces, SharedLight* light,
                         const SharedNormals* normals, const CellBoxes& where, TileMail& mail,
                         const core::Threads& threads)
    : part_(part), settings_(settings), tracer_(tracer), surfaces_(surfaces), light_(light),
      normals_(normals), where_(where), mail_(mail), threads_(threads) {}

void SharedPaths::trace(std::span<const Tile> tiles) {
  std::vector<std::pair<std::size_t, std::size_t>> waves; // by tile and part
  part_.world.agree_after([&] {
    count_ = tiles.size();
    if (batches_.size() < count_)
      batches_.resize(count_);
    for (std::size_t i = 0; i < count_; ++i) {
      Batch& batch = batches_[i];
      batch.slot = tiles[i].slot;
      batch.parts = tiles[i].parts.size();
      if (batch.waves.size() < batch.parts)
        batch.waves.resize(batch.parts);
      batch.asked.resize(std::size_t(part_.world.size()));
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
    part_.world.agree_after([&] {
      for (std::size_t i = 0; i < count_; ++i)
        waiting += collect(batches_[i]);
    });
    part_.world.reduce(std::span(&waiting, 1), parallel::Reduction::greatest);
    if (waiting == 0)
      break;
    std::vector<TileParcel> parcels;
    part_.world.agree_after([&] {
      std::vector<std::vector<TileParcel>> of(count_);
      core::for_each(threads_, count_, [&](std::size_t i) { ask(batches_[i], of[i]); });
      for (std::vector<TileParcel>& some : of)
        std::move(some.begin(), some.end(), std::back_inserter(parcels));
    });
    const std::vector<TileParcel> questions = mail_.exchange(std::move(parcels));
    std::vector<TileParcel> answers;
    std::vector<WallRays> walls; // by question
    part_.world.agree_after([&] {
      walls.resize(questions.size());
      if (surfaces_)
        core::for_each(threads_, questions.size(),
                       [&](std::size_t q) { walls[q] = find_walls(questions[q]); });
    });
    if (normals_)
      normals_->find(walls.size(), [&](std::size_t q) { return std::span(walls[q]); });
    part_.world.agree_after([&] {
      answers.resize(questions.size());
      core::for_each(threads_, questions.size(), [&](std::size_t q) {
        answers[q] = {questions[q].rank, questions[q].slot, answer(questions[q], walls[q])};
      });
    });
    const std::vector<TileParcel> received = mail_.exchange(std::move(answers));
    part_.world.agree_after([&] {
      core::for_each(threads_, count_, [&](std::size_t i) { take(batches_[i], received); });
    });
    if (surfaces_)
      light_walls();
    part_.world.agree_after([&] {
      core::for_each(threads_, waves.size(), [&](std::size_t w) {
        const auto [i, p] = waves[w];
        batches_[i].waves[p].go_on();
      });
    });
  }
  part_.world.agree_after([&] {
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
  thread_local ByteWriter writer; // for the thread's life
  for (int process = 0; process < part_.world.size(); ++process) {
    Asked& asked = batch.asked[std::size_t(process)];
    const auto pick = [](const std::vector<Path*>& paths, std::vector<std::uint32_t>& picked,
                         const auto& may_know) {
      picked.clear();
      for (std::size_t i = 0; i < paths.size(); ++i)
        if (may_know(*paths[i]))
          picked.push_back(std::uint32_t(i));
    };
    pick(batch.values, asked.values,
         [&](const Path& path) { return where_.may_hold(process, path.place()); });
    pick(batch.lights, asked.lights,
         [&](const Path& path) { return where_.may_meet(process, path.ray, path.far); });
    pick(batch.walls, asked.walls,
         [&](const Path& path) { return where_.may_meet(process, path.ray, HUGE_VAL); });
    if (asked.values.empty() && asked.lights.empty() && asked.walls.empty())
      continue;
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
    parcels.push_back({process, batch.slot, writer.bytes()});
  }
}

namespace {

SharedLight::Rays::One light_ray(const Ray& ray, double t_max, std::size_t point) {
  return {ray, t_max, std::uint32_t(point)};
}

} // namespace

std::vector<std::byte> SharedPaths::answer(const TileParcel& asked, const WallRays& walls) const {
  thread_local ByteWriter writer; // for the thread's life
  writer.clear();
  ByteReader reader = asked.reader();
  const auto head = reader.value<Head>();
  answer_values(reader, head.values, writer);
  if (!surfaces_)
    return writer.bytes();
  std::vector<SharedLight::Rays::One> rays;
  for (std::size_t i = 0; i < head.lights; ++i) {
    const auto sent = reader.value<SentRay>();
    rays.push_back(light_ray({sent.origin, sent.direction}, sent.t_max, i));
  }
  SurfaceCounts none; // as of one process, which does not count them either
  light_->write_met(0, SharedLight::Rays(std::move(rays)), {}, none, writer);
  write_hits(walls, part_.key, surfaces_->light_shader(), writer);
  return writer.bytes();
}

/// The hits of scattered light in this process's cells.
SharedPaths::WallRays SharedPaths::find_walls(const TileParcel& asked) const {
  ByteReader reader = asked.reader();
  const auto head = reader.value<Head>();
  reader.skip<Vec3d>(head.values);
  reader.skip<SentRay>(head.lights);
  WallRays rays(head.walls);
  for (RayState& ray : rays) {
    const auto sent = reader.value<SentRay>();
    ray.begin({sent.origin, sent.direction});
    clip_ray(settings_.clips, ray.ray, 0, HUGE_VAL, ray.stays);
  }
  SurfaceCounts none;
  surfaces_->find_own(rays, nullptr, none);
  return rays;
}

/// The values at places that cells of this process hold.
void SharedPaths::answer_values(ByteReader& from, std::size_t count, ByteWriter& to) const {
  const auto places = from.array<Vec3d>(count);
  std::vector<PlaceValue> found(count);
  tracer_.find_values(places, found);
  for (PlaceValue& value : found)
    value.cell = part_.own_key(tracer_.mesh(), value.cell);
  write_values(found, to);
}

/// Puts the answers about a batch together.
void SharedPaths::take(Batch& batch, std::span<const TileParcel> answers) const {
  for (Path* path : batch.values)
    path->found = {};
  std::vector<SharedLight::Rays::One> sent;
  for (std::size_t i = 0; i < batch.lights.size(); ++i)
    sent.push_back(light_ray(batch.lights[i]->ray, batch.lights[i]->far, i));
  const SharedLight::Rays rays(std::move(sent));
  std::vector<double> open(batch.lights.size(), 1.0);
  SharedLight::Met met;
  if (batch.wall_rays.size() < batch.walls.size())
    batch.wall_rays.resize(batch.walls.size());
  for (std::size_t i = 0; i < batch.walls.size(); ++i) {
    RayState& state = batch.wall_rays[i];
    state.begin(batch.walls[i]->ray);
    clip_ray(settings_.clips, state.ray, 0, HUGE_VAL, state.stays);
  }
  for (const TileParcel& parcel : answers) {
    if (parcel.slot != batch.slot)
      continue;
    const Asked& asked = batch.asked[std::size_t(parcel.rank)];
    ByteReader reader = parcel.reader();
    read_values(reader, asked.values,
                [&](std::uint32_t i) -> PlaceValue& { return batch.values[i]->found; });
    if (!surfaces_)
      continue;
    SharedLight::read_met(reader, rays, asked.lights, open, met);
    read_hits(reader, surfaces_->light_shader(), parcel.rank, asked.walls, batch.wall_rays);
  }
  if (!surfaces_)
    return;
  light_->pass(0, rays, met, open);
  for (std::size_t i = 0; i < batch.lights.size(); ++i)
    batch.lights[i]->open = open[i];
  take_walls(batch);
}

/// At which of the hits scattered light ends: it alone stays.
void SharedPaths::take_walls(Batch& batch) const {
  const std::span<RayState> rays(batch.wall_rays.data(), batch.walls.size());
  surfaces_->put_in_order(rays);
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
    surfaces_->set_color(hits.front());
  }
}

/// Lights the surfaces at which scattered light ends.
void SharedPaths::light_walls() {
  std::vector<SharedLight::Seen> seen;
  part_.world.agree_after([&] {
    seen.resize(count_);
    for (std::size_t b = 0; b < count_; ++b) {
      Batch& batch = batches_[b];
      seen[b].slot = batch.slot;
      for (std::size_t i = 0; i < batch.walls.size(); ++i)
        if (RayState& state = batch.wall_rays[i]; !state.hits.empty())
          seen[b].hits.push_back({&state.ray, batch.walls[i]->seed, state.hits.data()});
    }
    SurfaceCounts none;
    if (surfaces_->lights_hits() && !surfaces_->light_shader())
      for (const SharedLight::Seen& of_tile : seen)
        surfaces_->light(of_tile.hits, none);
  });
  if (surfaces_->light_shader())
    light_->light(0, seen);
  part_.world.agree_after([&] {
    for (std::size_t b = 0; b < count_; ++b)
      for (std::size_t i = 0; i < batches_[b].walls.size(); ++i)
        if (const auto& hits = batches_[b].wall_rays[i].hits; !hits.empty())
          batches_[b].walls[i]->wall_color = hits.front().color;
  });
}

} // namespace insitu::render

#include "render/processes/shared_light.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/for_each.h"
#include "render/processes/shared_light_data.h"

namespace insitu::render {

using math::Vec3d;

/// What was asked of whom, about a batch and a layer.
struct SharedLight::Asked {
  std::vector<std::vector<std::uint32_t>> points; ///< by process: the points that it got
};

/// A batch, and what was asked about it.
struct SharedLight::Question {
  Batch* batch;
  std::size_t first; ///< the layer that counts first
  std::optional<Rays> rays;
  std::vector<Asked> of; ///< by layer
};

SharedLight::SharedLight(std::vector<Layer> layers, TileMail& mail, const core::Threads& threads)
    : layers_(std::move(layers)), world_(layers_[0].part->world), mail_(mail), threads_(threads) {}

void SharedLight::count(const SurfaceCounts& counts) {
  const std::lock_guard lock(mutex_);
  counts_ += counts;
}

void SharedLight::ask(std::size_t first, const Shader& shader, bool with_volumes,
                      std::span<Batch> batches) {
  std::vector<Question> of;
  std::vector<TileParcel> parcels;
  const auto for_each = [&](auto&& work) { core::for_each(threads_, of.size(), work); };
  const auto collect = [&](auto&& write) { // parcels, in the order of batches
    std::vector<std::vector<TileParcel>> some(of.size());
    for_each([&](std::size_t b) { write(of[b], some[b]); });
    for (std::vector<TileParcel>& these : some)
      std::move(these.begin(), these.end(), std::back_inserter(parcels));
  };
  // Whom to ask.
  world_.agree_after([&] {
    of.resize(batches.size());
    for (std::size_t b = 0; b < batches.size(); ++b) {
      of[b].batch = &batches[b];
      of[b].first = first;
    }
    collect([&](Question& q, std::vector<TileParcel>& to) { begin(first, shader, q, to); });
  });
  const std::vector<TileParcel> points = mail_.exchange(std::move(parcels));
  parcels.clear();
  world_.agree_after([&] {
    parcels.resize(points.size());
    core::for_each(threads_, points.size(), [&](std::size_t q) {
      parcels[q] = {points[q].rank, points[q].slot, answer(shader, points[q])};
    });
  });
  const std::vector<TileParcel> answers = mail_.exchange(std::move(parcels));
  parcels.clear();
  world_.agree_after([&] {
    for_each([&](std::size_t b) { follow(of[b], answers); });
    if (with_volumes)
      collect([&](const Question& q, std::vector<TileParcel>& to) { open_shadows(q, to); });
  });
  if (with_volumes)
    ask_shadows(shader, of, points, std::move(parcels));
}

/// Makes the rays of a batch's points, and asks of these those whose cells the rays may meet.
void SharedLight::begin(std::size_t first, const Shader& shader, Question& question,
                        std::vector<TileParcel>& parcels) {
  const Batch& batch = *question.batch;
  SurfaceCounts counts;
  const Rays& rays = question.rays.emplace(
      shader, batch.points.size(),
      [&](std::size_t i) -> const SurfacePoint& { return batch.points[i].at; }, counts);
  count(counts);
  question.of.resize(layers_.size());
  for_each_layer(first, [&](std::size_t layer) {
    std::vector<std::vector<std::uint32_t>>& points = question.of[layer].points;
    points.resize(std::size_t(world_.size()));
    for (std::size_t p = 0; p < points.size(); ++p) {
      ByteWriter writer;
      for (std::size_t i = 0; i < batch.points.size(); ++i) {
        const auto from = rays.all.begin() + rays.first[i],
                   to = rays.all.begin() + rays.first[i + 1];
        if (std::none_of(from, to, [&](const Rays::One& one) {
              return layers_[layer].where->may_meet(int(p), one.ray, one.t_max);
            }))
          continue;
        const LightPoint& point = batch.points[i];
        const bool starts_here = layer == first && point.process == int(p);
        points[p].push_back(std::uint32_t(i));
        writer.value(SentPoint{point.at.position, point.at.normal, point.at.clearance,
                               point.at.seed, starts_here ? point.process_cell : -1,
                               point.surface});
      }
      if (!writer.empty())
        parcels.push_back({int(p), slot_of(batch.slot, layer), writer.bytes()});
    }
  });
}

/// Asks of the rays that are open what comes through the volumes. points: that were asked.
void SharedLight::ask_shadows(const Shader& shader, std::span<Question> questions,
                              std::span<const TileParcel> points, std::vector<TileParcel> parcels) {
  const std::vector<TileParcel> open = mail_.exchange(std::move(parcels));
  parcels.clear();
  world_.agree_after([&] {
    parcels.resize(open.size());
    core::for_each(threads_, open.size(), [&](std::size_t q) {
      const auto asked = std::find_if(points.begin(), points.end(), [&](const TileParcel& parcel) {
        return parcel.rank == open[q].rank && parcel.slot == open[q].slot;
      });
      parcels[q] = {open[q].rank, open[q].slot, answer_shadow(shader, *asked, open[q].reader())};
    });
  });
  const std::vector<TileParcel> answers = mail_.exchange(std::move(parcels));
  world_.agree_after([&] {
    core::for_each(threads_, questions.size(), [&](std::size_t b) {
      const std::vector<double> asked = questions[b].batch->open;
      for_each_layer(questions[b].first, [&](std::size_t layer) {
        if (layers_[layer].surfaces->volume_shadow())
          darken(questions[b], layer, asked, answers);
      });
    });
  });
}

/// Tells which rays are open, of those that a process has been asked about.
void SharedLight::open_shadows(const Question& question, std::vector<TileParcel>& parcels) const {
  const Rays& rays = *question.rays;
  for_each_layer(question.first, [&](std::size_t layer) {
    const std::vector<std::vector<std::uint32_t>>& points = question.of[layer].points;
    for (std::size_t p = 0; p < points.size() && layers_[layer].surfaces->volume_shadow(); ++p) {
      std::vector<std::uint64_t> open;
      std::size_t at = 0;
      for (const std::uint32_t i : points[p])
        for (std::uint32_t r = rays.first[i]; r < rays.first[i + 1]; ++r, ++at) {
          open.resize(words_of(at + 1));
          open[at / 64] |= std::uint64_t(question.batch->open[r] > 0) << (at % 64);
        }
      if (at > 0)
        parcels.push_back({int(p), slot_of(question.batch->slot, layer), parallel::bytes_of(open)});
    }
  });
}

void SharedLight::light(std::size_t layer, std::span<const Seen> tiles) {
  const Surfaces& surfaces = *layers_[layer].surfaces;
  const Shader& shader = *surfaces.light_shader();
  const bool with_volumes = std::any_of(layers_.begin(), layers_.end(), [](const Layer& of) {
    return of.surfaces && of.surfaces->volume_shadow();
  });
  std::vector<Batch> batches;
  std::vector<std::size_t> next;
  world_.agree_after([&] {
    batches.resize(tiles.size());
    next.resize(tiles.size());
  });
  for (;;) {
    std::int64_t left = 0;
    for (std::size_t i = 0; i < tiles.size(); ++i)
      left += std::int64_t(tiles[i].hits.size() - next[i]);
    world_.reduce(std::span(&left, 1), parallel::Reduction::greatest);
    if (left == 0)
      return;
    world_.agree_after([&] {
      core::for_each(threads_, tiles.size(),
                     [&](std::size_t i) { take_points(layer, tiles[i], next[i], batches[i]); });
    });
    ask(layer, shader, with_volumes, batches);
    world_.agree_after([&] {
      core::for_each(threads_, tiles.size(), [&](std::size_t i) {
        const double* open = batches[i].open.data();
        const auto next_open = [&](int) { return *open++; };
        for (const LightPoint& point : batches[i].points)
          Surfaces::shade(*tiles[i].hits[next[i]++].hit, shader.factor(point.at, next_open));
      });
    });
  }
}

/// The next hits, with not too many rays.
void SharedLight::take_points(std::size_t layer, const Seen& seen, std::size_t next, Batch& batch) {
  const Surfaces& surfaces = *layers_[layer].surfaces;
  SurfaceCounts counts;
  std::size_t rays = 0;
  batch.slot = seen.slot;
  batch.points.clear();
  for (; next < seen.hits.size() && rays < rays_at_once; ++next) {
    const SurfaceHit& hit = *seen.hits[next].hit;
    batch.points.push_back(
        {surfaces.point_of(seen.hits[next], counts), hit.surface, hit.process, hit.process_cell});
    rays += surfaces.light_shader()->most_rays();
  }
  counts.lit += std::int64_t(batch.points.size());
  count(counts);
}

/// Puts the answers about a batch together: what comes through each mesh is a factor.
void SharedLight::follow(Question& question, std::span<const TileParcel> answers) const {
  std::vector<double>& open = question.batch->open;
  open.assign(question.rays->all.size(), 1.0);
  std::vector<double> through;
  for_each_layer(question.first, [&](std::size_t layer) {
    const std::uint32_t slot = slot_of(question.batch->slot, layer);
    Met met;
    through.assign(open.size(), 1.0);
    for (const TileParcel& parcel : answers)
      if (parcel.slot == slot) {
        ByteReader reader = parcel.reader();
        read_met(reader, *question.rays, question.of[layer].points[std::size_t(parcel.rank)],
                 through, met);
      }
    pass(layer, *question.rays, met, through);
    for (std::size_t r = 0; r < open.size(); ++r)
      open[r] *= through[r];
  });
}

void SharedLight::read_met(ByteReader& from, const Rays& rays,
                           std::span<const std::uint32_t> points, std::vector<double>& open,
                           Met& met) {
  std::size_t count = 0, at = 0;
  for (const std::uint32_t i : points)
    count += rays.first[i + 1] - rays.first[i];
  const auto bits = from.array<std::uint64_t>(words_of(count));
  for (const std::uint32_t i : points)
    for (std::uint32_t r = rays.first[i]; r < rays.first[i + 1]; ++r, ++at) {
      if (!(bits[at / 64] >> (at % 64) & 1))
        continue;
      const auto hits = from.value<std::uint32_t>();
      if (hits == ray_ends)
        open[r] = 0;
      for (std::uint32_t h = 0; hits != ray_ends && h < hits; ++h)
        met.emplace_back(r, from.value<SentMeeting>().hit());
    }
}

void SharedLight::pass(std::size_t layer, const Rays& rays, Met& met,
                       std::vector<double>& open) const {
  const FrameSettings& settings = *layers_[layer].settings;
  std::stable_sort(met.begin(), met.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<SurfaceHit> hits;
  std::vector<Stretch> stays;
  std::size_t next = 0;
  for (std::uint32_t r = 0; r < open.size(); ++r) {
    hits.clear();
    for (; next < met.size() && met[next].first == r; ++next)
      hits.push_back(met[next].second);
    if (!(open[r] > 0) || (hits.empty() && settings.bodies.empty()))
      continue;
    const Rays::One& one = rays.all[r];
    clip_ray(settings.clips, one.ray, 0, one.t_max, stays);
    open[r] = layers_[layer].surfaces->open({one.ray, &stays}, hits);
  }
}

/// asked: the rays about which the answers are, those above 0.
void SharedLight::darken(Question& question, std::size_t layer, std::span<const double> asked,
                         std::span<const TileParcel> answers) const {
  const Rays& rays = *question.rays;
  std::vector<double>& open = question.batch->open;
  const std::uint32_t slot = slot_of(question.batch->slot, layer);
  struct Sample {
    std::uint32_t ray;
    VolumeShadow::Claim claim;
  };
  std::vector<Sample> samples;
  for (const TileParcel& parcel : answers) {
    if (parcel.slot != slot)
      continue;
    ByteReader reader = parcel.reader();
    for (const std::uint32_t i : question.of[layer].points[std::size_t(parcel.rank)])
      for (std::uint32_t r = rays.first[i]; r < rays.first[i + 1]; ++r)
        if (asked[r] > 0)
          for (auto left = reader.value<std::uint32_t>(); left > 0; --left) {
            const auto sent = reader.value<SentShadowSample>();
            samples.push_back({r, {sent.index, sent.key, sent.opacity}});
          }
  }
  std::sort(samples.begin(), samples.end(), [](const Sample& a, const Sample& b) {
    return std::tie(a.ray, a.claim.index, a.claim.cell) <
           std::tie(b.ray, b.claim.index, b.claim.cell);
  });
  std::vector<VolumeShadow::Claim> claims;
  for (std::size_t s = 0; s < samples.size();) {
    const std::uint32_t r = samples[s].ray;
    for (claims.clear(); s < samples.size() && samples[s].ray == r; ++s)
      if (claims.empty() || claims.back().index != samples[s].claim.index)
        claims.push_back(samples[s].claim); // of the lowest cell
    open[r] *= VolumeShadow::through(claims);
  }
}

} // namespace insitu::render

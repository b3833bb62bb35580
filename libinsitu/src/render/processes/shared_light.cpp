#include "render/processes/shared_light.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "core/for_each.h"
#include "render/processes/shared_light_data.h"

namespace insitu::render {

using math::Vec3d;

/// What was asked of whom, about a batch.
struct SharedLight::Asked {
  std::vector<std::vector<std::uint32_t>> points; ///< by process: the points that it got
};

SharedLight::SharedLight(const FramePart& part, const FrameSettings& settings,
                         const Surfaces& surfaces, const CellBoxes& where, TileMail& mail,
                         const core::Threads& threads)
    : part_(part), settings_(settings), surfaces_(surfaces), mail_(mail), threads_(threads),
      where_(where) {}

void SharedLight::count(const SurfaceCounts& counts) {
  const std::lock_guard lock(mutex_);
  counts_ += counts;
}

void SharedLight::ask(const Shader& shader, const VolumeShadow* shadow, std::span<Batch> batches) {
  const auto processes = std::size_t(part_.world.size());
  std::vector<std::optional<Rays>> rays;
  std::vector<Asked> asked;
  std::vector<TileParcel> parcels;
  // Whom to ask.
  part_.world.agree_after([&] {
    rays.resize(batches.size());
    asked.resize(batches.size());
    std::vector<std::vector<TileParcel>> of(batches.size());
    core::for_each(threads_, batches.size(), [&](std::size_t b) {
      const Batch& batch = batches[b];
      SurfaceCounts counts;
      rays[b].emplace(
          shader, batch.points.size(),
          [&](std::size_t i) -> const SurfacePoint& { return batch.points[i].at; }, counts);
      count(counts);
      asked[b].points.resize(processes);
      for (std::size_t p = 0; p < processes; ++p) {
        ByteWriter writer;
        for (std::size_t i = 0; i < batch.points.size(); ++i) {
          const auto begin = rays[b]->all.begin() + rays[b]->first[i],
                     end = rays[b]->all.begin() + rays[b]->first[i + 1];
          if (std::none_of(begin, end, [&](const Rays::One& one) {
                return where_.may_meet(int(p), one.ray, one.t_max);
              }))
            continue;
          const LightPoint& point = batch.points[i];
          asked[b].points[p].push_back(std::uint32_t(i));
          writer.value(SentPoint{point.at.position, point.at.normal, point.at.clearance,
                                 point.at.seed, point.process == int(p) ? point.process_cell : -1,
                                 point.surface});
        }
        if (!writer.empty())
          of[b].push_back({int(p), batch.slot, writer.bytes()});
      }
    });
    for (std::vector<TileParcel>& some : of)
      std::move(some.begin(), some.end(), std::back_inserter(parcels));
  });
  const std::vector<TileParcel> questions = mail_.exchange(std::move(parcels));
  parcels.clear();
  part_.world.agree_after([&] {
    parcels.resize(questions.size());
    core::for_each(threads_, questions.size(), [&](std::size_t q) {
      parcels[q] = {questions[q].rank, questions[q].slot, answer(shader, questions[q])};
    });
  });
  std::vector<TileParcel> answers = mail_.exchange(std::move(parcels));
  parcels.clear();
  part_.world.agree_after([&] {
    std::vector<std::vector<TileParcel>> of(batches.size());
    core::for_each(threads_, batches.size(), [&](std::size_t b) {
      follow(batches[b], *rays[b], answers, asked[b]);
      if (!shadow)
        return;
      for (std::size_t p = 0; p < processes; ++p) {
        std::vector<std::uint64_t> open;
        std::size_t at = 0;
        for (const std::uint32_t i : asked[b].points[p])
          for (std::uint32_t r = rays[b]->first[i]; r < rays[b]->first[i + 1]; ++r, ++at) {
            open.resize(words_of(at + 1));
            open[at / 64] |= std::uint64_t(batches[b].open[r] > 0) << (at % 64);
          }
        if (at > 0)
          of[b].push_back({int(p), batches[b].slot, parallel::bytes_of(open)});
      }
    });
    for (std::vector<TileParcel>& some : of)
      std::move(some.begin(), some.end(), std::back_inserter(parcels));
  });
  if (!shadow)
    return;
  const std::vector<TileParcel> open = mail_.exchange(std::move(parcels));
  parcels.clear();
  part_.world.agree_after([&] {
    parcels.resize(open.size());
    core::for_each(threads_, open.size(), [&](std::size_t q) {
      const auto question =
          std::find_if(questions.begin(), questions.end(), [&](const TileParcel& parcel) {
            return parcel.rank == open[q].rank && parcel.slot == open[q].slot;
          });
      parcels[q] = {open[q].rank, open[q].slot,
                    answer_shadow(shader, *shadow, *question, open[q].reader())};
    });
  });
  answers = mail_.exchange(std::move(parcels));
  part_.world.agree_after([&] {
    core::for_each(threads_, batches.size(),
                   [&](std::size_t b) { darken(batches[b], *rays[b], answers, asked[b]); });
  });
}

void SharedLight::light(std::span<const Seen> tiles) {
  const Shader& shader = *surfaces_.light_shader();
  std::vector<Batch> batches;
  std::vector<std::size_t> next;
  part_.world.agree_after([&] {
    batches.resize(tiles.size());
    next.resize(tiles.size());
  });
  for (;;) {
    std::int64_t left = 0;
    for (std::size_t i = 0; i < tiles.size(); ++i)
      left += std::int64_t(tiles[i].hits.size() - next[i]);
    part_.world.reduce(std::span(&left, 1), parallel::Reduction::greatest);
    if (left == 0)
      return;
    part_.world.agree_after([&] {
      core::for_each(threads_, tiles.size(),
                     [&](std::size_t i) { take_points(tiles[i], next[i], batches[i]); });
    });
    ask(shader, surfaces_.volume_shadow(), batches);
    part_.world.agree_after([&] {
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
void SharedLight::take_points(const Seen& seen, std::size_t next, Batch& batch) {
  SurfaceCounts counts;
  std::size_t rays = 0;
  batch.slot = seen.slot;
  batch.points.clear();
  for (; next < seen.hits.size() && rays < rays_at_once; ++next) {
    const SurfaceHit& hit = *seen.hits[next].hit;
    batch.points.push_back(
        {surfaces_.point_of(seen.hits[next], counts), hit.surface, hit.process, hit.process_cell});
    rays += surfaces_.light_shader()->most_rays();
  }
  counts.lit += std::int64_t(batch.points.size());
  count(counts);
}

/// Puts the answers about a batch together.
void SharedLight::follow(Batch& batch, const Rays& rays, std::span<const TileParcel> answers,
                         Asked& asked) const {
  batch.open.assign(rays.all.size(), 1.0);
  Met met;
  for (const TileParcel& parcel : answers)
    if (parcel.slot == batch.slot) {
      ByteReader reader = parcel.reader();
      read_met(reader, rays, asked.points[std::size_t(parcel.rank)], batch.open, met);
    }
  pass(rays, met, batch.open);
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

void SharedLight::pass(const Rays& rays, Met& met, std::vector<double>& open) const {
  std::stable_sort(met.begin(), met.end(),
                   [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<SurfaceHit> hits;
  std::vector<Stretch> stays;
  std::size_t next = 0;
  for (std::uint32_t r = 0; r < open.size(); ++r) {
    hits.clear();
    for (; next < met.size() && met[next].first == r; ++next)
      hits.push_back(met[next].second);
    if (!(open[r] > 0) || (hits.empty() && settings_.bodies.empty()))
      continue;
    const Rays::One& one = rays.all[r];
    clip_ray(settings_.clips, one.ray, 0, one.t_max, stays);
    open[r] = surfaces_.open({one.ray, &stays}, hits);
  }
}

void SharedLight::darken(Batch& batch, const Rays& rays, std::span<const TileParcel> answers,
                         const Asked& asked) const {
  struct Sample {
    std::uint32_t ray;
    VolumeShadow::Claim claim;
  };
  std::vector<Sample> samples;
  for (const TileParcel& parcel : answers) {
    if (parcel.slot != batch.slot)
      continue;
    ByteReader reader = parcel.reader();
    for (const std::uint32_t i : asked.points[std::size_t(parcel.rank)])
      for (std::uint32_t r = rays.first[i]; r < rays.first[i + 1]; ++r)
        if (batch.open[r] > 0)
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
    batch.open[r] *= VolumeShadow::through(claims);
  }
}

} // namespace insitu::render

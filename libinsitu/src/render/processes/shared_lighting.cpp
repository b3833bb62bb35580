#include <algorithm>
#include <bit>

#include "render/processes/shared_frame.h"

/// What rays of light reach of the surfaces and the volume of a frame of several processes.
namespace insitu::render {

namespace {

/// Rays of light of a tile that are followed at a time: a megabyte and a half.
constexpr std::size_t light_rays_at_once = std::size_t(1) << 15;

} // namespace

/// Lights the hits of own tiles by rays that all processes follow.
void SharedFrame::light_hits() {
  const Shader& shader = *surfaces_->light_shader();
  std::vector<SharedLight::Batch> batches;
  std::vector<std::vector<Surfaces::Seen>> seen;
  std::vector<std::size_t> next;
  part_.world.agree_after([&] {
    batches.resize(own_count_);
    seen.resize(own_count_);
    next.resize(own_count_);
    for_tiles(own_count_, [&](std::size_t i) { surfaces_->see(rays_of(own_[i]), seen[i]); });
  });
  for (;;) {
    std::int64_t left = 0;
    for (std::size_t i = 0; i < own_count_; ++i)
      left += std::int64_t(seen[i].size() - next[i]);
    part_.world.reduce(std::span(&left, 1), parallel::Reduction::greatest);
    if (left == 0)
      break;
    part_.world.agree_after([&] {
      for_tiles(own_count_,
                [&](std::size_t i) { take_points(own_[i], seen[i], next[i], batches[i]); });
    });
    light_->ask(shader, surfaces_->volume_shadow(), batches);
    part_.world.agree_after([&] {
      for_tiles(own_count_, [&](std::size_t i) {
        SharedLight::Batch& batch = batches[i];
        const double* open = batch.open.data();
        const auto next_open = [&](int) { return *open++; };
        for (const LightPoint& point : batch.points)
          Surfaces::shade(*seen[i][next[i]++].hit, shader.factor(point.at, next_open));
      });
    });
  }
  part_.world.agree_after([&] {
    for_tiles(own_count_, [&](std::size_t i) { surfaces_->add_lines(rays_of(own_[i])); });
  });
}

/// The next hits, with not too many rays.
void SharedFrame::take_points(const OwnTile& tile, std::span<const Surfaces::Seen> seen,
                              std::size_t next, SharedLight::Batch& batch) {
  SurfaceCounts counts;
  std::size_t rays = 0;
  batch.slot = tile.slot;
  batch.points.clear();
  for (; next < seen.size() && rays < light_rays_at_once; ++next) {
    const SurfaceHit& hit = *seen[next].hit;
    batch.points.push_back(
        {surfaces_->point_of(seen[next], counts), hit.surface, hit.process, hit.process_cell});
    rays += surfaces_->light_shader()->most_rays();
  }
  const std::lock_guard lock(mutex_);
  surface_counts_.lit += std::int64_t(batch.points.size());
}

/// The points of the next claims that are to be lit, with not too many rays; and of each of these
/// claims, ray by ray, which of its samples.
void SharedFrame::take_points(const OwnTile& tile, ClaimReader ahead, const Round& round,
                              SharedLight::Batch& batch, LitSamples& lit) const {
  const Shader& shader = *volume_->light_shader();
  std::size_t sent = 0;
  batch.slot = tile.slot;
  batch.points.clear();
  lit.clear();
  while (sent < light_rays_at_once && ahead.next()) {
    const std::size_t r = ahead.ray();
    const std::uint32_t wanted =
        round.is_thin ? 1u
                      : volume_->lit_samples(tile.rays[r], *tile.progress, r, round.first,
                                             ahead.wanted(), ahead.samples());
    lit.push_back(wanted);
    for (std::uint32_t rest = wanted; rest; rest &= rest - 1)
      if (const auto point = lit_point(tile, ahead, std::countr_zero(rest))) {
        batch.points.push_back({*point});
        sent += shader.most_rays();
      }
  }
}

/// Gathers claims whose light is found by rays that all processes follow.
void SharedFrame::gather_by_rays_of_light(std::span<const TileParcel> received,
                                          const Round& round) {
  const Shader& shader = *volume_->light_shader();
  std::vector<ClaimReader> claims;
  std::vector<SharedLight::Batch> batches;
  std::vector<LitSamples> lit;
  part_.world.agree_after([&] {
    for (std::size_t i = 0; i < own_count_; ++i)
      claims.push_back(claims_of(own_[i], received));
    batches.resize(own_count_);
    lit.resize(own_count_);
  });
  for (;;) {
    std::int64_t rays = 0;
    part_.world.agree_after([&] {
      for_tiles(own_count_,
                [&](std::size_t i) { take_points(own_[i], claims[i], round, batches[i], lit[i]); });
      for (const LitSamples& samples : lit)
        rays += std::int64_t(samples.size());
    });
    part_.world.reduce(std::span(&rays, 1), parallel::Reduction::greatest);
    if (rays == 0)
      return;
    light_->ask(shader, nullptr, batches);
    part_.world.agree_after([&] {
      for_tiles(own_count_, [&](std::size_t i) {
        auto point = batches[i].points.begin();
        const double* open = batches[i].open.data();
        const auto next_open = [&](int) { return *open++; };
        for (const std::uint32_t wanted : lit[i]) {
          claims[i].next();
          for (std::uint32_t rest = wanted; rest; rest &= rest - 1) {
            const int k = std::countr_zero(rest);
            Color light{1, 1, 1};
            if (lit_point(own_[i], claims[i], k))
              light = shader.factor((point++)->at, next_open);
            claims[i].set_light(k, {light.r, light.g, light.b});
          }
          take(own_[i], claims[i], round);
        }
      });
    });
  }
}

} // namespace insitu::render

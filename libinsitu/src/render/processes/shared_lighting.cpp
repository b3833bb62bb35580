#include <algorithm>
#include <bit>

#include "render/processes/shared_volume.h"

/// What rays of light reach of a volume of a frame of several processes.
namespace insitu::render {

/// The points of the next claims that are to be lit, with not too many rays; and of each of these
/// claims, ray by ray, which of its samples.
void SharedVolume::take_points(const OwnTile& tile, ClaimReader ahead, const Round& round,
                               SharedLight::Batch& batch, LitSamples& lit) const {
  const Shader& shader = *volume_.light_shader();
  std::size_t sent = 0;
  batch.slot = tile.slot;
  batch.points.clear();
  lit.clear();
  while (sent < SharedLight::rays_at_once && ahead.next()) {
    const std::size_t r = ahead.ray();
    const std::uint32_t wanted =
        round.is_thin ? 1u
                      : volume_.lit_samples(tile.rays[r], *tile.progress, r, round.first,
                                            ahead.wanted(), ahead.samples(), ahead.levels());
    lit.push_back(wanted);
    for (std::uint32_t rest = wanted; rest; rest &= rest - 1)
      if (const auto point = lit_point(tile, ahead, std::countr_zero(rest))) {
        batch.points.push_back({*point});
        sent += shader.most_rays();
      }
  }
}

/// Gathers claims whose light is found by rays that all processes follow.
void SharedVolume::gather_by_rays_of_light(std::span<const TileParcel> received,
                                           const Round& round) {
  const Shader& shader = *volume_.light_shader();
  std::vector<ClaimReader> claims;
  std::vector<SharedLight::Batch> batches;
  std::vector<LitSamples> lit;
  part_.world.agree_after([&] {
    for (std::size_t i = 0; i < tiles_.own.size(); ++i)
      claims.push_back(claims_of(tiles_.own[i], received, round));
    batches.resize(tiles_.own.size());
    lit.resize(tiles_.own.size());
  });
  for (;;) {
    std::int64_t rays = 0;
    part_.world.agree_after([&] {
      for_tiles(tiles_.own.size(), [&](std::size_t i) {
        take_points(tiles_.own[i], claims[i], round, batches[i], lit[i]);
      });
      for (const LitSamples& samples : lit)
        rays += std::int64_t(samples.size());
    });
    part_.world.reduce(std::span(&rays, 1), parallel::Reduction::greatest);
    if (rays == 0)
      return;
    beside_.light->ask(beside_.light_first, shader, false, batches);
    part_.world.agree_after([&] {
      for_tiles(tiles_.own.size(), [&](std::size_t i) {
        auto point = batches[i].points.begin();
        const double* open = batches[i].open.data();
        const auto next_open = [&](int) { return *open++; };
        for (const std::uint32_t wanted : lit[i]) {
          claims[i].next();
          for (std::uint32_t rest = wanted; rest; rest &= rest - 1) {
            const int k = std::countr_zero(rest);
            Color light{1, 1, 1};
            if (lit_point(tiles_.own[i], claims[i], k))
              light = shader.factor((point++)->at, next_open);
            claims[i].set_light(k, {light.r, light.g, light.b});
          }
          take(tiles_.own[i], claims[i], round);
        }
      });
    });
  }
}

} // namespace insitu::render

#include "advect/lines/snapshots.h"

namespace insitu::advect {

void Snapshots::grow(std::size_t particle_count) {
  const std::size_t before = particles;
  if (particle_count <= before)
    return;
  particles = std::max(particle_count, before + before / 2); // rows move, so seldom
  const std::size_t items = times.size() * particles;
  positions.resize(items);
  places.resize(items);
  present.resize(items);
  hops.resize(particles, 0);
  for (std::size_t k = times.size(); k-- > 0;) { // from the last on: rows move up
    std::copy_backward(positions.begin() + k * before, positions.begin() + (k + 1) * before,
                       positions.begin() + k * particles + before);
    std::copy_backward(places.begin() + k * before, places.begin() + (k + 1) * before,
                       places.begin() + k * particles + before);
    std::copy_backward(present.begin() + k * before, present.begin() + (k + 1) * before,
                       present.begin() + k * particles + before);
    std::fill(present.begin() + k * particles + before, present.begin() + (k + 1) * particles,
              std::uint8_t(0));
  }
}

} // namespace insitu::advect

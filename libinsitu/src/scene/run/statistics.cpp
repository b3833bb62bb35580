#include "scene/run/statistics.h"

#include <cmath>
#include <tuple>

namespace insitu::scene {

SecondsOfAll seconds_of_all(const Seconds& mine, parallel::World& world) {
  SecondsOfAll all{world.size(), mine, mine, mine};
  if (all.processes == 1)
    return all;
  world.reduce(std::span(all.least), parallel::Reduction::least);
  world.reduce(std::span(all.greatest), parallel::Reduction::greatest);
  std::array<std::int64_t, std::tuple_size_v<Seconds>> sums{};
  for (std::size_t i = 0; i < sums.size(); ++i)
    sums[i] = std::llround(1e9 * mine[i]);
  world.reduce(std::span(sums), parallel::Reduction::sum);
  for (std::size_t i = 0; i < sums.size(); ++i)
    all.mean[i] = 1e-9 * double(sums[i]) / all.processes;
  return all;
}

SecondsOfAll ProcessSeconds::since_last(const Statistics& now, parallel::World& world) {
  Seconds seconds = seconds_of(now);
  const Seconds until_now = seconds;
  for (std::size_t i = 0; i < seconds.size(); ++i)
    seconds[i] -= before_[i];
  earlier_ = before_;
  before_ = until_now;
  return seconds_of_all(seconds, world);
}

} // namespace insitu::scene

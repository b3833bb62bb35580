#include "advect/across/exits_across.h"

#include <algorithm>
#include <vector>

#include "parallel/bytes.h"

namespace insitu::advect {

void tell_exits(parallel::World& world, Exits& exits, const query::Sampler& inside,
                std::span<const LeftAt> left, Particles& particles) {
  constexpr std::size_t most = std::size_t(1) << 14; // of a process at a time
  std::int64_t rounds = std::int64_t((left.size() + most - 1) / most);
  world.reduce(std::span(&rounds, 1), parallel::Reduction::greatest);
  for (std::int64_t round = 0; round < rounds; ++round) {
    const std::size_t first = std::min(left.size(), std::size_t(round) * most);
    const std::span<const LeftAt> part = left.subspan(first, std::min(most, left.size() - first));
    std::vector<std::uint8_t> endings;
    std::vector<parallel::Parcel> parcels, answers;
    world.agree_after([&] {
      std::vector<Exits::Beyond> beyond(part.size());
      for (std::size_t i = 0; i < part.size(); ++i)
        endings.push_back(std::uint8_t(exits.ending(inside, part[i], &beyond[i])));
      for (int r = 0; r < world.size(); ++r)
        if (r != world.rank() && !beyond.empty())
          parcels.push_back({r, parallel::bytes_of(beyond)});
    });
    const std::vector<parallel::Parcel> asked = world.exchange(parcels);
    world.agree_after([&] {
      for (const parallel::Parcel& parcel : asked) {
        parallel::Parcel& answer = answers.emplace_back(parallel::Parcel{parcel.rank, {}});
        for (const Exits::Beyond& of : parallel::items_of<Exits::Beyond>(parcel.bytes))
          answer.bytes.push_back(std::byte(exits.ending(inside, of)));
      }
    });
    const std::vector<parallel::Parcel> answered = world.exchange(answers);
    world.agree_after([&] {
      for (const parallel::Parcel& parcel : answered)
        for (std::size_t i = 0; i < part.size(); ++i)
          endings[i] = std::uint8_t(
              Exits::stronger(insitu_ending(endings[i]), insitu_ending(parcel.bytes[i])));
      for (std::size_t i = 0; i < part.size(); ++i)
        particles.endings[part[i].particle] = endings[i];
    });
  }
}

} // namespace insitu::advect

#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "measure.h"

namespace insitu::bench {

/// What an effect adds to work that goes without it.
struct EffectPrice {
  std::string kind, effect; ///< of frame, or of particles; its prices stand together
  Series bare, with;        ///< in turns
  std::int64_t bytes_added = 0;
  std::int64_t evaluations_bare = 0, evaluations = 0; ///< of the velocity; particles alone

  /// Time with it over time without; and over the bare work's median, of the repetition that took
  /// least and of the one that took most.
  double ratio(int threads) const { return with.for_ratio(threads) / bare.for_ratio(threads); }
  double least_ratio(int threads) const {
    return (threads == 1 ? with.cpu_min() : with.min()) / bare.for_ratio(threads);
  }
  double most_ratio(int threads) const {
    return (threads == 1 ? with.cpu_max() : with.max()) / bare.for_ratio(threads);
  }
};

/// One row an effect.
std::string csv(const std::vector<EffectPrice>& prices, int threads);
/// A row each: the time over that of the bare work, logarithmic, with its spread.
std::string plot(const std::vector<EffectPrice>& prices, int threads);

} // namespace insitu::bench

#include <algorithm>

#include "commands.h"

namespace insitu::bench {

Latency time_single_points(const query::Sampler& sampler, std::span<const math::Vec3d> points) {
  points = points.first(std::min<std::size_t>(points.size(), 20'000));
  std::int64_t found = 0;
  const auto microseconds = [&](insitu_accuracy accuracy, bool hinted) {
    query::LocateOptions options;
    options.accuracy = accuracy;
    Series series;
    for (int i = 0; i < 3; ++i)
      series.time([&] {
        std::int64_t hint = -1;
        for (const math::Vec3d& p : points) {
          const query::Location at = sampler.locate(p, hint, options);
          found += bool(at);
          if (hinted && at)
            hint = at.cell;
        }
      });
    return 1e6 * series.median() / double(std::max<std::size_t>(points.size(), 1));
  };
  Latency out;
  out.single = microseconds(INSITU_STANDARD, false);
  out.single_exact = microseconds(INSITU_EXACT, false);
  out.hinted = microseconds(INSITU_STANDARD, true);
  out.found = found;
  return out;
}

} // namespace insitu::bench

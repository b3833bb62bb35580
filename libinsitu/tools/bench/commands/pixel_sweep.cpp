#include "commands/pixel_sweep.h"

#include <algorithm>
#include <cmath>

#include "report/format.h"
#include "commands/kept_frames.h"
#include "report/report.h"

namespace insitu::bench {

PixelSweep sweep_pixels(const commit::CommittedMesh& mesh, core::Memory& memory,
                        render::FrameSettings settings, int size, int repetitions) {
  const core::Threads single(1);
  KeptFrames frames(mesh, memory, single);
  PixelSweep sweep;
  sweep.text =
      format("\nthe volume by size, on one core\n%14s %9s %12s\n", "pixels", "s", "ns a pixel");
  std::vector<double> all_pixels, all_seconds;
  for (const double factor : {0.5, 0.75, 1.0, 1.5, 2.0}) {
    const int side = std::max(1, int(std::lround(factor * size)));
    progress(format("volume of %d x %d", side, side));
    settings.width = settings.height = side;
    const double seconds = frames.time(settings, repetitions), pixels = double(side) * side;
    sweep.text += format("%7d x %-4d %9.3f %12.0f\n", side, side, seconds, 1e9 * seconds / pixels);
    sweep.json["by_pixels"].push_back({{"side", side}, {"s", number(seconds)}});
    all_pixels.push_back(pixels);
    all_seconds.push_back(seconds);
  }
  const double power = power_of(all_pixels, all_seconds);
  sweep.text += format("time goes as the pixels to the power of %.2f\n", power);
  sweep.json["power_of_pixels"] = number(power);
  return sweep;
}

} // namespace insitu::bench

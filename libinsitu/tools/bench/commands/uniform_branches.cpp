#include "commands/uniform_branches.h"

#include <algorithm>
#include <vector>

#include "report/format.h"
#include "measure.h"
#include "report/report.h"

namespace insitu::bench {

namespace {

struct Branches {
  double count = 0;
  std::string of; ///< what they are
};

/// Every branch on a setting that the family's loops have, each as often as the loop it is in goes
/// around, whether or not another one guards it.
Branches branches_of(const BareFrame& frame) {
  const render::FrameStatistics& s = frame.statistics;
  const auto rays = double(s.rays);
  if (frame.family == "volume") {
    // A ray's samples are taken 16 at once or more, in stretches of the bundle's lattice, which a
    // ray's own begin and end need not fit.
    const double stretches = double(s.samples + s.skipped) / 16 + 2 * rays;
    return {6 * stretches + double(s.samples) + 8 * rays,
            "a sample: depth; a stretch of a ray: space skipping, clips, pre-integration, lights, "
            "a tolerance, surfaces; a ray: clips twice, surfaces twice, depth, cell, paths, thin "
            "volumes"};
  }
  if (frame.family == "isosurface")
    return {4 * double(s.cells_tested) + 8 * double(s.hits) + 8 * rays,
            "a cell tested: other fields, other values, clips, the search; a hit: opacity, colour, "
            "lights, shadows, occlusion, normals, volume shadows, outline; a ray: as above"};
  const render::PathCounts& p = s.paths;
  const auto flights = double(p.locations + p.paths + p.shadow_rays + p.scatterings);
  return {
      flights + 6 * double(p.collisions) + 4 * double(p.scatterings) + 4 * double(p.paths) +
          8 * rays,
      "a flight: clips; a collision: scattering three times, depth, small lights, surfaces; a "
      "scattering: single, dome, surfaces twice; a path: surfaces, dome, depth, sums; a ray: as "
      "above"};
}

/// At most the part of a frame's time that is spent on them.
double share(const BareFrame& frame) {
  return branches_of(frame).count * frame.branch_seconds / frame.seconds;
}

} // namespace

double uniform_branches::measure_branch() {
  constexpr int flag_count = 16;
  constexpr std::int64_t rounds = 1 << 20;
  volatile bool flags[flag_count] = {};
  volatile std::int64_t taken = 0;
  Series with, without;
  for (int r = 0; r < 25; ++r) { // some milliseconds each
    without.time([&] {
      for (std::int64_t i = 0; i < rounds; ++i)
        asm volatile("" ::: "memory");
    });
    with.time([&] {
      for (std::int64_t i = 0; i < rounds; ++i) {
        asm volatile("" ::: "memory");
#pragma GCC unroll 16
        for (int k = 0; k < flag_count; ++k)
          if (flags[k])
            taken = taken + 1;
      }
    });
  }
  return std::max(0.0, with.cpu_min() - without.cpu_min()) / (double(rounds) * flag_count);
}

std::string uniform_branches::text(std::span<const BareFrame> frames) {
  std::string out =
      format("\nUniform branches of bare frames, for effects that they do not ask for; "
             "what one takes, measured in turns with the frame.\n\n"
             "%-14s %14s %8s %9s  %s\n",
             "frame", "at most", "ns each", "of time", "tested");
  for (const BareFrame& frame : frames) {
    const Branches branches = branches_of(frame);
    out += format("%-14s %14s %8.2f %8.2f%%  %s\n", frame.family.c_str(),
                  grouped(std::int64_t(branches.count)).c_str(), 1e9 * frame.branch_seconds,
                  100 * share(frame), branches.of.c_str());
  }
  return out;
}

void uniform_branches::add(std::span<const BareFrame> frames, Json& rows) {
  for (const BareFrame& frame : frames)
    rows.push_back({{"frame", frame.family},
                    {"effect", "uniform branches"},
                    {"branches", std::int64_t(branches_of(frame).count)},
                    {"branch_ns", number(1e9 * frame.branch_seconds)},
                    {"share_of_time", number(share(frame))}});
}

} // namespace insitu::bench

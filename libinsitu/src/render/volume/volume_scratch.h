#pragma once

#include <cstdint>
#include <vector>

#include "query/ray_bundle/ray_bundle.h"
#include "render/volume/volume.h"

namespace insitu::render {

/// What a ray last met, for the stretch up to what it meets next.
struct VolumeMarcher::Gathered {
  std::int64_t index = -1; ///< of the sample; -1: none that is still open
  Preintegration::Place place; ///< of its value
  query::Location at;
};

/// With a tolerance: a sample for stride(level) base steps from `begin` on.
struct VolumeMarcher::Planned {
  std::int64_t begin;
  int level;
};

struct VolumeMarcher::Scratch {
  std::vector<std::uint32_t> active;
  std::vector<std::uint32_t> wanted; ///< masks, by ray
  std::vector<math::Vec3d> points;
  std::vector<query::Location> found; ///< of the points
  std::vector<query::LatticeRay> rays;
  std::vector<query::ValueSample> samples; ///< [ray][depth]
  std::vector<query::Location> locations;  ///< where they are, for lights
  std::vector<Gathered> last;              ///< by ray
  std::vector<VolumeMarcher::Run> open_runs; ///< by ray; begin -1: there is none
  // With a tolerance.
  struct Run { ///< base steps up to `end` in macrocells of one level
    std::int64_t end;
    int level;
    bool visible;
  };
  std::vector<Run> runs;
  std::vector<Planned> planned, all_planned; ///< of one ray; of the active ones
  std::vector<std::size_t> planned_end;      ///< by active ray
};

} // namespace insitu::render

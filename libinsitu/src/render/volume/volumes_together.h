#pragma once

#include <span>

#include "render/volume/volume.h"

namespace insitu::render {

/// As VolumeMarcher::start() and march() of several volumes, two or more. Where stretches of
/// several lie in one place their optical depths add up, and so does what they emit: of depths
/// t and colours c, the opacity is 1 - exp(-sum t) and the colour sum(t c) / sum t. A stretch that
/// another one or a hit cuts has an optical depth in proportion to the length. An opaque one hides
/// those in its place that are not. layers: of the volumes, see RayState::volume_layer.
VolumeCounts march_together(std::span<const VolumeMarcher* const> volumes,
                            std::span<const std::int32_t> layers, std::span<RayState> rays,
                            int row);

/// Begins a ray that one of several volumes is marched along, for its stretches alone. `ray` has
/// its hits, the last of which may end it. The hit is to be cleared after VolumeMarcher::start().
void begin_alone(RayState& alone, const RayState& ray);

/// Those that are kept of a layer's volume.
struct LayerStretches {
  std::span<const VolumeStretch> stretches;
  std::int32_t layer = 0;
};
/// What it makes of a ray, whose hits are in order, and of the stretches of each volume.
void blend_together(RayState& ray, std::span<const LayerStretches> volumes);

} // namespace insitu::render

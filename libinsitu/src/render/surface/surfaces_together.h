#pragma once

#include <span>

#include "render/surface/surfaces.h"

namespace insitu::render {

/// As Surfaces::trace() of the surfaces of several meshes, which were joined with each other and
/// stand by SurfaceHit::layer. tiles: the same, each holds the isosurfaces' hits or is null.
void trace_together(std::span<const Surfaces* const> surfaces, std::span<RayState> rays,
                    std::span<IsosurfaceTile* const> tiles, SurfaceCounts& counts);

} // namespace insitu::render

#pragma once

#include <span>

#include "render/surface/surfaces.h"

namespace insitu::render {

/// Makes the hits of rays with the surfaces of several meshes one order, by distance, up to the
/// first opaque one. find(layer) sets the hits of all rays with one mesh, in order.
void put_hits_together(std::size_t layers, std::span<RayState> rays,
                       core::FunctionRef<void(std::size_t layer)> find);

/// The same of hits that tell their layers and are in no order, those that processes have found.
/// surfaces: by layer; null: the layer has none.
void order_together(std::span<const Surfaces* const> surfaces, std::span<RayState> rays);

/// As Surfaces::trace() of the surfaces of several meshes, which were joined with each other and
/// stand by SurfaceHit::layer; null: the layer has none. tiles: the same, each holds the
/// isosurfaces' hits or is null.
void trace_together(std::span<const Surfaces* const> surfaces, std::span<RayState> rays,
                    std::span<IsosurfaceTile* const> tiles, SurfaceCounts& counts);

} // namespace insitu::render

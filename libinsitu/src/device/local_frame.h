#pragma once

#include <cstdint>

#include "core/memory.h"
#include "device/stream.h"
#include "mesh/view.h"

namespace insitu::device {

/// The middle of the box of one vertex of every cell that owns points; vertices beyond any float
/// box do not count. Waits for the stream.
math::Vec3d middle_of_cells(const mesh::MeshView& mesh, std::int64_t cells, core::Memory& memory,
                            StreamHandle stream);

/// x, y, z of every vertex less the origin, as floats.
void float_vertices(const mesh::MeshView& mesh, std::int64_t count, const math::Vec3d& origin,
                    float* out, StreamHandle stream);

} // namespace insitu::device

#pragma once

#include <cstdint>
#include <cuda_runtime_api.h>

#include "core/memory.h"
#include "mesh/view.h"

namespace insitu::accel::cuda {

/// The middle of the box of one vertex of every cell that owns points; vertices beyond any float
/// box do not count. Waits for the stream.
math::Vec3d middle_of_cells(const mesh::MeshView& mesh, std::int64_t cells, core::Memory& memory,
                            cudaStream_t stream);

/// x, y, z of every vertex less the origin, as floats.
void float_vertices(const mesh::MeshView& mesh, std::int64_t count, const math::Vec3d& origin,
                    float* out, cudaStream_t stream);

} // namespace insitu::accel::cuda

#pragma once

#include "accel/faces/face_triangle.h"
#include "accel/tree/node.h"
#include "device/buffer.h"
#include "mesh/view.h"

/// CUDA kernels behind the structures of the rays. Views and pointers are the device's.
namespace insitu::accel::optix {

/// Queues the boxes of cells[first, first + n), outwards, in the local frame. cells: flat ids, or
/// null for all cells in order.
void fill_cell_boxes(const mesh::MeshView& mesh, const math::Vec3d& origin,
                     const std::uint32_t* cells, std::int64_t first, std::int64_t n, Box* boxes,
                     device::StreamHandle stream);

/// The largest distance of two vertices of one of the cells, as a float rounded up; waits.
/// MeshFaces::longest_distance, on the device.
float longest_distance(const mesh::MeshView& mesh, const std::uint32_t* cells, std::int64_t n,
                       device::Buffer<std::uint32_t>& scratch, device::StreamHandle stream);

/// Whether triangles of shared_bilinear_faces cease to be right for moved vertices: a bounding
/// tetrahedron turned inside out, or a planar quad is no more. Slight changes that floats do not
/// resolve do not count. Waits.
bool quads_turned(const FaceTriangle* triangles, std::int64_t n, const float* vertices,
                  device::Buffer<std::uint32_t>& scratch, device::StreamHandle stream);

} // namespace insitu::accel::optix

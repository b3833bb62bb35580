#include <cub/device/device_reduce.cuh>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>

#include "accel/cuda/device_buffer.h"
#include "accel/cuda/frame_kernels.h"
#include "accel/cuda/launch.h"
#include "accel/tree/extent.h"

namespace insitu::accel::cuda {

namespace {

struct Bounds {
  double low[3], high[3];
};

struct JoinBounds {
  __host__ __device__ Bounds operator()(const Bounds& a, const Bounds& b) const {
    Bounds out;
    for (int i = 0; i < 3; ++i) {
      out.low[i] = b.low[i] < a.low[i] ? b.low[i] : a.low[i];
      out.high[i] = b.high[i] > a.high[i] ? b.high[i] : a.high[i];
    }
    return out;
  }
};

constexpr Bounds no_bounds{{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};

struct FirstVertex {
  mesh::MeshView mesh;
  __device__ Bounds operator()(std::int64_t flat) const {
    Bounds out = no_bounds;
    const std::int32_t p = mesh.piece_of(flat);
    const mesh::PieceView& piece = mesh.pieces[p];
    const std::int64_t cell = flat - mesh.first_cell[p];
    if (!piece.exists(cell))
      return out;
    std::int64_t ids[8];
    if (piece.vertex_ids(cell, ids) == 0)
      return out;
    const math::Vec3d x = piece.point(ids[0]);
    for (int a = 0; a < 3; ++a)
      if (fabs(x[a]) <= largest_coordinate)
        out.low[a] = out.high[a] = x[a];
    return out;
  }
};

__global__ void float_vertices_kernel(mesh::MeshView mesh, std::int64_t count, math::Vec3d origin,
                                      float* out) {
  const std::int64_t flat = global_thread();
  if (flat >= count)
    return;
  std::int32_t p = 0;
  while (p + 1 < mesh.piece_count && mesh.first_vertex[p + 1] <= flat)
    ++p;
  const math::Vec3d x = mesh.pieces[p].point(flat - mesh.first_vertex[p]) - origin;
  for (int a = 0; a < 3; ++a)
    out[3 * flat + a] = float(x[a]);
}

} // namespace

math::Vec3d middle_of_cells(const mesh::MeshView& mesh, std::int64_t cells, core::Memory& memory,
                            cudaStream_t stream) {
  math::Vec3d middle{};
  if (cells == 0)
    return middle;
  const auto firsts = thrust::make_transform_iterator(thrust::counting_iterator<std::int64_t>(0),
                                                      FirstVertex{mesh});
  DeviceBuffer<Bounds> result(memory);
  DeviceBuffer<std::byte> scratch(memory);
  result.resize_discard(1);
  std::size_t bytes = 0;
  const auto reduce = [&](void* temporary) {
    check(cub::DeviceReduce::Reduce(temporary, bytes, firsts, result.data(), cells, JoinBounds{},
                                    no_bounds, stream),
          "finding the mesh's middle");
  };
  reduce(nullptr);
  scratch.resize_discard(bytes);
  reduce(scratch.data());
  Bounds b;
  check(cudaMemcpyAsync(&b, result.data(), sizeof b, cudaMemcpyDeviceToHost, stream),
        "finding the mesh's middle");
  check(cudaStreamSynchronize(stream), "finding the mesh's middle");
  for (int a = 0; a < 3; ++a)
    middle[a] = b.low[a] > b.high[a] ? 0.0 : 0.5 * b.low[a] + 0.5 * b.high[a];
  return middle;
}

void float_vertices(const mesh::MeshView& mesh, std::int64_t count, const math::Vec3d& origin,
                    float* out, cudaStream_t stream) {
  if (count == 0)
    return;
  float_vertices_kernel<<<blocks_for(count), threads_a_block, 0, stream>>>(mesh, count, origin,
                                                                           out);
  check_launch("making the vertices' floats");
}

} // namespace insitu::accel::cuda

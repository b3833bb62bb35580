#include "accel/extent.h"
#include "accel/optix/kernels.h"

namespace insitu::accel::optix {
namespace {

constexpr unsigned block = 256;

unsigned blocks_of(std::int64_t n) {
  return unsigned((n + block - 1) / block);
}

__device__ std::int64_t thread_index() {
  return std::int64_t(blockIdx.x) * block + threadIdx.x;
}

__global__ void box_kernel(mesh::MeshView mesh, math::Vec3d origin, const std::uint32_t* cells,
                           std::int64_t first, std::int64_t n, Box* boxes) {
  const std::int64_t i = thread_index();
  if (i >= n)
    return;
  mesh::CellVertices cell;
  mesh::gather(mesh, cells ? cells[first + i] : first + i, cell);
  Extent extent(cell.x[0]);
  for (int v = 1; v < cell.count; ++v)
    extent.add(cell.x[v]);
  boxes[i] = extent.box(origin);
}

/// Lengths are not negative, so their bits are in their order.
__global__ void distance_kernel(mesh::MeshView mesh, const std::uint32_t* cells, std::int64_t n,
                                std::uint32_t* longest) {
  const std::int64_t i = thread_index();
  float length = 0.0f;
  if (i < n) {
    mesh::CellVertices cell;
    mesh::gather(mesh, cells ? cells[i] : i, cell);
    double square = 0.0;
    for (int v = 1; v < cell.count; ++v)
      for (int w = 0; w < v; ++w) {
        const math::Vec3d d = cell.x[v] - cell.x[w];
        square = fmax(square, math::dot(d, d));
      }
    length = round_up(sqrt(square) * (1.0 + 0x1p-40));
  }
  for (int lane = 16; lane > 0; lane /= 2)
    length = fmaxf(length, __shfl_xor_sync(0xffffffffu, length, lane));
  if (threadIdx.x % 32 == 0)
    atomicMax(longest, __float_as_uint(length));
}

__global__ void difference_kernel(const std::uint32_t* a, const std::uint32_t* b,
                                  std::int64_t words, std::uint32_t* differ) {
  const std::int64_t i = thread_index();
  if (i < words && a[i] != b[i])
    *differ = 1;
}

/// A number in device memory: starts at 0.
void reset(cuda::DeviceBuffer<std::uint32_t>& scratch, cudaStream_t stream) {
  scratch.resize_discard(1);
  cuda::check(cudaMemsetAsync(scratch.data(), 0, sizeof(std::uint32_t), stream), "clearing");
}
std::uint32_t read(const cuda::DeviceBuffer<std::uint32_t>& scratch, cudaStream_t stream) {
  std::uint32_t value = 0;
  cuda::check(cudaMemcpyAsync(&value, scratch.data(), sizeof value, cudaMemcpyDeviceToHost, stream),
              "reading a result");
  cuda::check(cudaStreamSynchronize(stream), "waiting for a result");
  return value;
}

} // namespace

void fill_cell_boxes(const mesh::MeshView& mesh, const math::Vec3d& origin,
                     const std::uint32_t* cells, std::int64_t first, std::int64_t n, Box* boxes,
                     cudaStream_t stream) {
  if (n == 0)
    return;
  box_kernel<<<blocks_of(n), block, 0, stream>>>(mesh, origin, cells, first, n, boxes);
  cuda::check_launch("computing boxes of cells");
}

float longest_distance(const mesh::MeshView& mesh, const std::uint32_t* cells, std::int64_t n,
                       cuda::DeviceBuffer<std::uint32_t>& scratch, cudaStream_t stream) {
  if (n == 0)
    return 0.0f;
  reset(scratch, stream);
  distance_kernel<<<blocks_of(n), block, 0, stream>>>(mesh, cells, n, scratch.data());
  cuda::check_launch("finding the longest distance in a cell");
  return std::bit_cast<float>(read(scratch, stream));
}

bool same_triangles(const FaceTriangle* a, const FaceTriangle* b, std::int64_t n,
                    cuda::DeviceBuffer<std::uint32_t>& scratch, cudaStream_t stream) {
  if (n == 0)
    return true;
  const std::int64_t words = n * std::int64_t(sizeof(FaceTriangle) / sizeof(std::uint32_t));
  reset(scratch, stream);
  difference_kernel<<<blocks_of(words), block, 0, stream>>>(
      reinterpret_cast<const std::uint32_t*>(a), reinterpret_cast<const std::uint32_t*>(b), words,
      scratch.data());
  cuda::check_launch("comparing triangles");
  return read(scratch, stream) == 0;
}

} // namespace insitu::accel::optix

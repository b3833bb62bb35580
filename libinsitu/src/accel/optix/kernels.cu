#include "accel/optix/kernels.h"
#include "accel/tree/extent.h"

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

/// Where a fourth vertex is against a triangle, in parts of the edges: a sine, about.
struct Corner {
  const float* vertices;

  __device__ math::Vec3d at(std::uint32_t v) const {
    const float* x = vertices + 3 * std::size_t(v);
    return {x[0], x[1], x[2]};
  }
  __device__ double height(const FaceTriangle& t, std::uint32_t fourth) const {
    const math::Vec3d o = at(t.vertices[0]), a = at(t.vertices[1]) - o, b = at(t.vertices[2]) - o,
                      c = at(fourth) - o;
    const double size = sqrt(dot(a, a) * dot(b, b) * dot(c, c));
    return size > 0.0 ? dot(cross(a, b), c) / size : 0.0;
  }
};

__global__ void turned_kernel(const FaceTriangle* triangles, std::int64_t n, const float* vertices,
                              std::uint32_t* turned) {
  constexpr double unresolved = 1e-5;
  const std::int64_t i = thread_index();
  if (i >= n)
    return;
  const FaceTriangle t = triangles[i];
  const Corner corner{vertices};
  if (t.corner != none) { // its normal points out of the tetrahedron
    if (corner.height(t, t.corner) > unresolved)
      *turned = 1;
    return;
  }
  if (i + 1 == n)
    return;
  const FaceTriangle u = triangles[i + 1]; // perhaps the other half of a planar quad
  const bool halves = u.corner == none && u.front == t.front && u.back == t.back &&
                      u.vertices[0] == t.vertices[0] && u.vertices[1] == t.vertices[2];
  if (halves && fabs(corner.height(t, u.vertices[2])) > unresolved)
    *turned = 1;
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

bool quads_turned(const FaceTriangle* triangles, std::int64_t n, const float* vertices,
                  cuda::DeviceBuffer<std::uint32_t>& scratch, cudaStream_t stream) {
  if (n == 0)
    return false;
  reset(scratch, stream);
  turned_kernel<<<blocks_of(n), block, 0, stream>>>(triangles, n, vertices, scratch.data());
  cuda::check_launch("looking for quads that turned");
  return read(scratch, stream) != 0;
}

} // namespace insitu::accel::optix

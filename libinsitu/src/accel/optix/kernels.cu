#include <bit>
#include <cmath>

#include "accel/locator.h"
#include "accel/optix/kernels.h"
#include "accel/tree/extent.h"
#include "device/arithmetic.cuh"
#include "device/launch.cuh"

namespace insitu::accel::optix {
namespace {

struct BoxKernel {
  mesh::MeshView mesh;
  math::Vec3d origin;
  const std::uint32_t* cells; ///< of the first item
  std::int64_t first;         ///< the first item's cell where cells is null
  Box* boxes;
  INSITU_HD void operator()(std::int64_t i) const {
    mesh::CellVertices cell;
    mesh::gather(mesh, cells ? cells[i] : first + i, cell);
    Extent extent(cell.x[0]);
    for (int v = 1; v < cell.count; ++v)
      extent.add(cell.x[v]);
    boxes[i] = extent.box(origin);
  }
};

/// Raises the bits of the longest distance: lengths are not negative, so their bits are in their
/// order. A warp raises it once.
struct DistanceKernel {
  mesh::MeshView mesh;
  const std::uint32_t* cells;
  std::int64_t count;
  std::uint32_t* longest;
  INSITU_HD void operator()(std::int64_t i) const {
    float length = i < count ? length_in(i) : 0.0f;
#if defined(__CUDA_ARCH__)
    for (int lane = warp / 2; lane > 0; lane /= 2)
      length = fmaxf(length, __shfl_xor_sync(0xffffffffu, length, lane));
    if (threadIdx.x % warp != 0)
      return;
#endif
    device::raise_to(longest, std::bit_cast<std::uint32_t>(length));
  }
  static constexpr int warp = 32; ///< items are a multiple of it

private:
  INSITU_HD float length_in(std::int64_t i) const {
    mesh::CellVertices cell;
    mesh::gather(mesh, cells ? cells[i] : i, cell);
    double square = 0.0;
    for (int v = 1; v < cell.count; ++v)
      for (int w = 0; w < v; ++w) {
        const math::Vec3d d = cell.x[v] - cell.x[w];
        square = std::fmax(square, math::dot(d, d));
      }
    return round_up(std::sqrt(square) * (1.0 + 0x1p-40));
  }
};

/// Where a fourth vertex is against a triangle, in parts of the edges: a sine, about.
struct Corner {
  const float* vertices;

  INSITU_HD math::Vec3d at(std::uint32_t v) const {
    const float* x = vertices + 3 * std::size_t(v);
    return {x[0], x[1], x[2]};
  }
  INSITU_HD double height(const FaceTriangle& t, std::uint32_t fourth) const {
    const math::Vec3d o = at(t.vertices[0]), a = at(t.vertices[1]) - o, b = at(t.vertices[2]) - o,
                      c = at(fourth) - o;
    const double size = std::sqrt(dot(a, a) * dot(b, b) * dot(c, c));
    return size > 0.0 ? dot(cross(a, b), c) / size : 0.0;
  }
};

struct TurnedKernel {
  const FaceTriangle* triangles;
  std::int64_t count;
  const float* vertices;
  std::uint32_t* turned;
  INSITU_HD void operator()(std::int64_t i) const {
    constexpr double unresolved = 1e-5;
    const FaceTriangle t = triangles[i];
    const Corner corner{vertices};
    if (t.corner != none) { // its normal points out of the tetrahedron
      if (corner.height(t, t.corner) > unresolved)
        *turned = 1;
      return;
    }
    if (i + 1 == count)
      return;
    const FaceTriangle u = triangles[i + 1]; // perhaps the other half of a planar quad
    const bool halves = u.corner == none && u.front == t.front && u.back == t.back &&
                        u.vertices[0] == t.vertices[0] && u.vertices[1] == t.vertices[2];
    if (halves && std::fabs(corner.height(t, u.vertices[2])) > unresolved)
      *turned = 1;
  }
};

/// A number in device memory: starts at 0.
void reset(device::Buffer<std::uint32_t>& scratch, device::StreamHandle stream) {
  scratch.resize_discard(1);
  device::fill(scratch.data(), 0, sizeof(std::uint32_t), stream, "clearing");
}
std::uint32_t read(const device::Buffer<std::uint32_t>& scratch, device::StreamHandle stream) {
  std::uint32_t value = 0;
  device::copy_to_host(&value, scratch.data(), sizeof value, stream, "reading a result");
  device::wait(stream, "waiting for a result");
  return value;
}

} // namespace

void fill_cell_boxes(const mesh::MeshView& mesh, const math::Vec3d& origin,
                     const std::uint32_t* cells, std::int64_t first, std::int64_t n, Box* boxes,
                     device::StreamHandle stream) {
  device::launch(n, BoxKernel{mesh, origin, cells ? cells + first : nullptr, first, boxes}, stream,
                 "computing boxes of cells");
}

float longest_distance(const mesh::MeshView& mesh, const std::uint32_t* cells, std::int64_t n,
                       device::Buffer<std::uint32_t>& scratch, device::StreamHandle stream) {
  if (n == 0)
    return 0.0f;
  reset(scratch, stream);
  constexpr std::int64_t warp = DistanceKernel::warp;
  device::launch((n + warp - 1) / warp * warp, DistanceKernel{mesh, cells, n, scratch.data()},
                 stream, "finding the longest distance in a cell");
  return std::bit_cast<float>(read(scratch, stream));
}

bool quads_turned(const FaceTriangle* triangles, std::int64_t n, const float* vertices,
                  device::Buffer<std::uint32_t>& scratch, device::StreamHandle stream) {
  if (n == 0)
    return false;
  reset(scratch, stream);
  device::launch(n, TurnedKernel{triangles, n, vertices, scratch.data()}, stream,
                 "looking for quads that turned");
  return read(scratch, stream) != 0;
}

} // namespace insitu::accel::optix

#include <cmath>

#include "device/algorithms.cuh"
#include "device/buffer.h"
#include "device/local_frame.h"
#include "math/number.h"

namespace insitu::device {

namespace {

struct Bounds {
  double low[3], high[3];
};

struct JoinBounds {
  INSITU_HD Bounds operator()(const Bounds& a, const Bounds& b) const {
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
  INSITU_HD Bounds operator()(std::int64_t flat) const {
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
      if (std::fabs(x[a]) <= math::largest_coordinate)
        out.low[a] = out.high[a] = x[a];
    return out;
  }
};

struct FloatVertices {
  mesh::MeshView mesh;
  math::Vec3d origin;
  float* out;
  INSITU_HD void operator()(std::int64_t flat) const {
    std::int32_t p = 0;
    while (p + 1 < mesh.piece_count && mesh.first_vertex[p + 1] <= flat)
      ++p;
    const math::Vec3d x = mesh.pieces[p].point(flat - mesh.first_vertex[p]) - origin;
    for (int a = 0; a < 3; ++a)
      out[3 * flat + a] = float(x[a]);
  }
};

} // namespace

math::Vec3d middle_of_cells(const mesh::MeshView& mesh, std::int64_t cells, core::Memory& memory,
                            StreamHandle stream) {
  math::Vec3d middle{};
  if (cells == 0)
    return middle;
  constexpr const char* what = "finding the mesh's middle";
  Buffer<Bounds> result(memory);
  Scratch scratch(memory);
  result.resize_discard(1);
  reduce<std::int64_t>(scratch, cells, FirstVertex{mesh}, JoinBounds{}, no_bounds, result.data(),
                       stream, what);
  Bounds b;
  copy_to_host(&b, result.data(), sizeof b, stream, what);
  wait(stream, what);
  for (int a = 0; a < 3; ++a)
    middle[a] = b.low[a] > b.high[a] ? 0.0 : 0.5 * b.low[a] + 0.5 * b.high[a];
  return middle;
}

void float_vertices(const mesh::MeshView& mesh, std::int64_t count, const math::Vec3d& origin,
                    float* out, StreamHandle stream) {
  launch(count, FloatVertices{mesh, origin, out}, stream, "making the vertices' floats");
}

} // namespace insitu::device

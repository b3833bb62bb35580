#pragma once

#include "mesh/view.h"

/// Ways to gather a cell's vertices in a batch: a general one over the cell interface, and one for
/// the most frequent mesh (one piece, one shape, evenly spaced arrays) whose number types are
/// chosen once a batch, and whose memory can be asked for ahead.
namespace insitu::query {

struct GeneralCells {
  const mesh::MeshView& mesh;
  double alpha;

  void prefetch_ids(std::int64_t) const {}
  void prefetch_points(std::int64_t) const {}
  mesh::Shape shape(std::int64_t flat) const {
    const std::int32_t p = mesh.piece_count == 1 ? 0 : mesh.piece_of(flat);
    return mesh.pieces[p].shape(flat - mesh.first_cell[p]);
  }
  template <class Put>
  void gather(std::int64_t flat, Put&& put) const {
    mesh::CellVertices cell;
    mesh::gather(mesh, flat, cell, alpha);
    for (int v = 0; v < cell.count; ++v)
      put(v, cell.x[v]);
  }
};

template <class Index, class Real, int count>
struct UniformCells {
  const std::byte* ids;
  std::int64_t cell_stride, id_stride, base;
  const std::byte* component[3];
  std::int64_t point_stride;
  mesh::Shape uniform_shape;
  bool interleaved;

  explicit UniformCells(const mesh::PieceView& p)
      : ids(p.connectivity.data), cell_stride(p.connectivity.stride), id_stride(p.id_stride),
        base(p.index_base), component{p.points.component[0], p.points.component[1],
                                      p.points.component[2]},
        point_stride(p.points.layout.stride[0]), uniform_shape(p.uniform_shape),
        interleaved(component[1] - component[0] == sizeof(Real) &&
                    component[2] - component[1] == sizeof(Real)) {}

  std::int64_t id(std::int64_t cell, int v) const {
    return std::int64_t(mesh::load_as<Index>(ids + cell * cell_stride + v * id_stride)) - base;
  }
  void prefetch_ids(std::int64_t cell) const { __builtin_prefetch(ids + cell * cell_stride); }
  /// Vertices 2 v and 2 v + 1 are neighbours in many meshes: the first one's beginning and the
  /// second one's end are the lines that both lie in.
  void prefetch_points(std::int64_t cell) const {
    if (interleaved) {
      for (int v = 0; v < count; ++v)
        __builtin_prefetch(component[v & 1 ? 2 : 0] + id(cell, v) * point_stride);
      return;
    }
    for (int v = 0; v < count; v += count == 4 ? 1 : 2)
      for (int a = 0; a < 3; ++a)
        __builtin_prefetch(component[a] + id(cell, v) * point_stride);
  }
  mesh::Shape shape(std::int64_t) const { return uniform_shape; }
  template <class Put>
  void gather(std::int64_t cell, Put&& put) const {
    for (int v = 0; v < count; ++v) {
      const std::int64_t o = id(cell, v) * point_stride;
      put(v, math::Vec3d{double(mesh::load_as<Real>(component[0] + o)),
                         double(mesh::load_as<Real>(component[1] + o)),
                         double(mesh::load_as<Real>(component[2] + o))});
    }
  }
};

/// Calls f with the source for the cells' vertex count.
template <class Index, class Real, class F>
void with_uniform_cells(const mesh::PieceView& p, F&& f) {
  switch (mesh::vertex_count(p.uniform_shape)) {
  case 4:
    return f(UniformCells<Index, Real, 4>(p));
  case 5:
    return f(UniformCells<Index, Real, 5>(p));
  case 6:
    return f(UniformCells<Index, Real, 6>(p));
  default:
    return f(UniformCells<Index, Real, 8>(p));
  }
}

/// Calls f with the source that suits the mesh.
template <class F>
void with_cells(const mesh::MeshView& mesh, double alpha, F&& f) {
  const mesh::PieceView& p = mesh.pieces[0];
  if (mesh.piece_count != 1 || alpha != 1.0 || p.layout != mesh::CellLayout::uniform ||
      p.implicit_points || !p.points.layout.linear)
    f(GeneralCells{mesh, alpha});
  else if (p.connectivity.is_int32)
    p.points.is_float32 ? with_uniform_cells<std::int32_t, float>(p, f)
                        : with_uniform_cells<std::int32_t, double>(p, f);
  else
    p.points.is_float32 ? with_uniform_cells<std::int64_t, float>(p, f)
                        : with_uniform_cells<std::int64_t, double>(p, f);
}

} // namespace insitu::query

#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "render/surface/isosurface.h"
#include "render/surface/tiles/trilinear_cell.h"

namespace insitu::render {

/// A cell that holds a value of a group of surfaces, as a patch of a space of the caller's.
struct ActiveCell {
  std::int64_t flat = 0;
  const IsosurfaceTracer::Group* group = nullptr;
  PatchDomain domain = PatchDomain::cube;
  math::Vec3d corner[8];
  double f[8];      ///< the field at the corners
  double low, high; ///< of the vertices' values

  /// A surface of the level passes through the cell.
  bool holds(const IsosurfaceTracer::Level& level) const {
    return low < level.value && level.value <= high;
  }
  /// Becomes patch p.
  void put(Patches& patches, int p) const {
    for (int c = 0; c < 8; ++c) {
      patches.x[c][p] = corner[c].x;
      patches.y[c][p] = corner[c].y;
      patches.z[c][p] = corner[c].z;
      patches.f[c][p] = f[c];
    }
    for (auto& lower : patches.lower)
      lower[p] = 0;
  }
};

/// A cell's vertices, looked up.
struct CellSource {
  std::int32_t piece;
  std::int64_t local;
  mesh::Shape shape;
  int count;
  std::int64_t ids[8];

  CellSource(const mesh::MeshView& mesh, std::int64_t flat) : piece(mesh.piece_of(flat)) {
    const mesh::PieceView& view = mesh.pieces[piece];
    local = flat - mesh.first_cell[piece];
    shape = view.shape(local);
    count = view.vertex_ids(local, ids);
  }
  void points(const mesh::MeshView& mesh, math::Vec3d* x) const {
    mesh.pieces[piece].cell_points(local, ids, count, x);
  }
};

/// visit(const ActiveCell&) for each group of which the cell holds a level. space: puts a point
/// into the caller's space.
template <class Space, class Visit>
void for_each_active(const IsosurfaceTracer& surfaces, std::int64_t flat, const Space& space,
                     Visit&& visit) {
  const mesh::MeshView& mesh = surfaces.sampler().mesh();
  const CellSource source(mesh, flat);
  const int n = source.count;
  ActiveCell cell;
  bool is_placed = false; // most cells below a candidate leaf end before their points are read
  for (const IsosurfaceTracer::Group& group : surfaces.groups()) {
    double values[8];
    if (!group.load(source.piece, source.local, source.ids, n, values))
      continue;
    const auto [low, high] = std::minmax_element(values, values + n);
    cell.low = *low;
    cell.high = *high;
    if (std::none_of(group.levels.begin(), group.levels.end(),
                     [&](const auto& level) { return cell.holds(level); }))
      continue;
    if (!is_placed) {
      math::Vec3d x[8];
      source.points(mesh, x);
      for (int v = 0; v < n; ++v)
        x[v] = space(x[v]);
      to_corners(source.shape, x, cell.corner);
      cell.flat = flat;
      cell.domain = domain_of(source.shape);
      is_placed = true;
    }
    cell.group = &group;
    to_corners(source.shape, values, cell.f);
    visit(std::as_const(cell));
  }
}

} // namespace insitu::render

#include "advect/field/owners.h"

#include <algorithm>

#include "cells/exact/decide.h"
#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"
#include "cells/kernels/on_feature.h"
#include "query/sound_cells.h"

namespace insitu::advect {

using math::Vec3d;
using mesh::Shape;

namespace {

/// Whether all of some ids are among others.
bool are_among(const std::int64_t* ids, int count, const std::int64_t* others, int other_count) {
  return std::all_of(ids, ids + count, [&](std::int64_t id) {
    return std::find(others, others + other_count, id) != others + other_count;
  });
}

/// The local vertices of a face, a bit each.
unsigned vertices_of(const cells::Face& face) {
  unsigned on = 0;
  for (int k = 0; k < face.vertex_count; ++k)
    on |= 1U << face.vertices[k];
  return on;
}

} // namespace

CellsAbout cells_about(const mesh::MeshView& mesh, const CellsBeyond& beyond, std::int64_t cell,
                       unsigned on) {
  CellsAbout about;
  const std::int32_t p = mesh.piece_of(cell);
  const mesh::PieceView& piece = mesh.pieces[p];
  std::int64_t feature[8], ids[8], others[8];
  int corners = 0;
  const int of_cell = piece.vertex_ids(cell - mesh.first_cell[p], ids);
  for (int v = 0; v < of_cell; ++v)
    if (on >> v & 1U)
      feature[corners++] = ids[v];
  about.cells[about.count++] = cell;
  for (int k = 0; k < about.count; ++k) {
    const std::int64_t from = about.cells[k] - mesh.first_cell[p];
    const Shape shape = piece.shape(from);
    if (k > 0)
      piece.vertex_ids(from, ids);
    const cells::FaceTable table = cells::face_table(shape);
    for (int f = 0; f < table.face_count; ++f) {
      std::int64_t face[4];
      const int n = table.faces[f].vertex_count;
      for (int v = 0; v < n; ++v)
        face[v] = ids[table.faces[f].vertices[v]];
      if (k == 0 ? (on & ~vertices_of(table.faces[f])) != 0 : !are_among(feature, corners, face, n))
        continue;
      const std::int64_t flat = beyond.across(about.cells[k], shape, f),
                         to = flat - mesh.first_cell[p];
      if (flat < 0 || to < 0 || to >= piece.cell_count || !piece.owns(to) ||
          piece.shape(to) == Shape::none ||
          !are_among(face, n, others, piece.vertex_ids(to, others)))
        return about;
      if (std::find(about.cells, about.cells + about.count, flat) != about.cells + about.count)
        continue;
      if (about.count == CellsAbout::most)
        return about;
      about.cells[about.count++] = flat;
      if (corners == n) { // no third cell has that face
        about.closed = true;
        return about;
      }
    }
  }
  about.closed = true;
  return about;
}

namespace {

/// The lowest of the cells, all sound, about the boundary of one that hold x, exactly; or none.
query::Location lowest_about(const mesh::MeshView& mesh, const query::SoundCells& sound,
                             CellsAbout about, const Vec3d& x, double alpha) {
  if (!about.closed || !std::all_of(about.cells, about.cells + about.count,
                                    [&](std::int64_t c) { return sound.is_sound(mesh, c); }))
    return {};
  std::sort(about.cells, about.cells + about.count);
  for (int k = 0; k < about.count; ++k) {
    mesh::CellVertices c;
    mesh::gather(mesh, about.cells[k], c, alpha);
    if (const cells::Decision why = cells::decide(c.shape, c.x, x))
      return {about.cells[k], cells::parametric_in(c.shape, c.x, x, why)};
  }
  return {};
}

} // namespace

query::Location owner_of(const query::Sampler& sampler, const CellsBeyond* beyond,
                         std::int64_t cell, const Vec3d& given,
                         const query::LocateOptions& options) {
  const query::SoundCells* const sound = sampler.sound_cells(options.alpha != 1.0);
  const mesh::MeshView& mesh = sampler.mesh();
  if (!sound || cell < 0 || cell >= mesh.cell_count() || sampler.chart() ||
      options.accuracy == INSITU_EXACT || !sampler.exists(cell))
    return sampler.locate(given, cell, options);
  mesh::CellVertices c;
  mesh::gather(mesh, cell, c, options.alpha);
  const auto map = cells::inverse_map(c.shape, c.x, given);
  if (map.margin > map.error && sound->is_sound(mesh, cell)) {
    sampler.count_certified(1);
    return {cell, map.r};
  }
  const bool on_boundary = beyond && cells::is_on_boundary(map.margin, map.error);
  if (const unsigned on = on_boundary ? cells::vertices_near(c.shape, map.r, map.error) : 0)
    if (const query::Location at = lowest_about(mesh, *sound, cells_about(mesh, *beyond, cell, on),
                                                given, options.alpha)) {
      sampler.count_on_faces(1);
      return at;
    }
  return sampler.locate(given, cell, options);
}

} // namespace insitu::advect

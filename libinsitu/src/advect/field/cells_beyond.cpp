#include "advect/field/cells_beyond.h"

#include <algorithm>
#include <bit>
#include <optional>
#include <vector>

#include "cells/kernels/faces.h"
#include "cells/kernels/kernels.h"
#include "cells/kernels/on_feature.h"
#include "mesh/view.h"
#include "query/on_demand.h"
#include "query/proof.h"

namespace insitu::advect {

using math::Vec3d;
using mesh::Shape;

namespace {

bool is_brick(Shape shape) {
  return shape == Shape::hexahedron || shape == Shape::voxel;
}

/// Coordinates a little beyond a side; see CellsBeyond::sides_beyond.
Vec3d beyond(Shape shape, int side) {
  constexpr double far = 0.05;
  if (is_brick(shape)) {
    Vec3d r{0.5, 0.5, 0.5};
    r[side / 2] = side % 2 == 0 ? -far : 1.0 + far;
    return r;
  }
  switch (side) {
  case 0:
    return {-far, 0.5, 0.5};
  case 1:
    return {0.5, -far, 0.5};
  case 2:
    return {0.5 + far, 0.5 + far, 0.5};
  case 3:
    return {1.0 / 3, 1.0 / 3, -far};
  default:
    return {1.0 / 3, 1.0 / 3, 1.0 + far};
  }
}

/// visit(cell, shape) for some of the cells that own points.
template <class Visit>
void for_a_few(const mesh::MeshView& mesh, Visit&& visit) {
  constexpr int looked_at = 9;
  for (int k = 0; k < looked_at; ++k) {
    const auto cell = std::int64_t(double(mesh.cell_count()) * (2 * k + 1) / (2 * looked_at));
    const std::int32_t p = mesh.piece_of(cell);
    const mesh::PieceView& piece = mesh.pieces[p];
    const std::int64_t local = cell - mesh.first_cell[p];
    if (!piece.in_runs() && piece.exists(local))
      visit(cell, piece.shape(local));
  }
}

} // namespace

CellsBeyond::CellsBeyond(const query::Sampler& sampler)
    : cells_(sampler.mesh().cell_count()), neighbours_(sampler.neighbours()) {
  if (neighbours_) {
    knows_ = knows_most_ = true;
    return;
  }
  const mesh::MeshView& mesh = sampler.mesh();
  if ((!query::ProofRule(mesh, sampler.odd(), {}).for_some() &&
       !sampler.sound_cells(mesh.earlier_points != nullptr)) ||
      mesh.cell_count() == 0)
    return;
  const query::NumberStepsCache* const kept =
      sampler.on_demand() ? &sampler.on_demand()->steps : nullptr;
  const std::optional<query::NumberSteps> known = kept ? kept->get() : std::nullopt;
  steps_ = known ? *known : learn(sampler);
  if (kept && !known)
    kept->put(steps_);
  for (const bool wedges : {false, true}) {
    const query::NumberSteps::Of& steps = of(wedges);
    knows_ |= steps.known != 0;
    knows_most_ |= std::popcount(steps.known) > (wedges ? 5 : most_sides) / 2;
  }
  lacks_neighbours_ = accel::FaceNeighbours::fits(mesh) && !tells_most(mesh);
}

query::NumberSteps CellsBeyond::learn(const query::Sampler& sampler) {
  // Without its counts: these are no queries of the caller's.
  const query::Sampler bare(sampler.mesh(), sampler.tree());
  query::NumberSteps steps;
  for (int side = 0; side < most_sides; ++side)
    learn(bare, false, side, steps.bricks);
  for (int side = 0; side < 5; ++side)
    learn(bare, true, side, steps.wedges);
  return steps;
}

/// The step over one side, if most of the cells that are looked at have it.
void CellsBeyond::learn(const query::Sampler& sampler, bool wedges, int side,
                        query::NumberSteps::Of& steps) {
  const mesh::MeshView& mesh = sampler.mesh();
  std::vector<std::int64_t> found;
  for_a_few(mesh, [&](std::int64_t cell, Shape shape) {
    if (wedges ? shape != Shape::wedge : !is_brick(shape))
      return;
    mesh::CellVertices c;
    mesh::gather(mesh, cell, c);
    double weight[8];
    cells::shape_functions(shape, beyond(shape, side), weight);
    Vec3d x = weight[0] * c.x[0];
    for (int v = 1; v < c.count; ++v)
      x += weight[v] * c.x[v];
    if (const query::Location at = sampler.locate(x); at && at.cell != cell)
      found.push_back(at.cell - cell);
  });
  if (found.size() < 3)
    return;
  std::sort(found.begin(), found.end());
  const std::int64_t step = found[found.size() / 2]; // what most have stands in the middle
  if (3 * std::size_t(std::count(found.begin(), found.end(), step)) >= 2 * found.size()) {
    steps.step[side] = step;
    steps.known |= 1U << side;
  }
}

std::int64_t CellsBeyond::across(std::int64_t cell, Shape shape, int face) const {
  if (cell >= cells_)
    return -1;
  if (neighbours_)
    return neighbours_->across(cell, face);
  const bool wedge = shape == Shape::wedge;
  if (!wedge && !is_brick(shape))
    return -1;
  constexpr int of_wedge[] = {3, 4, 1, 2, 0};
  const int side = wedge ? of_wedge[face] : face;
  const std::int64_t next = cell + of(wedge).step[side];
  return of(wedge).known >> side & 1U && next < cells_ ? next : -1;
}

bool CellsBeyond::tells_most(const mesh::MeshView& mesh) const {
  int told = 0, faces = 0;
  for_a_few(mesh, [&](std::int64_t, Shape shape) {
    faces += cells::face_table(shape).face_count;
    if (is_brick(shape) || shape == Shape::wedge)
      told += std::popcount(of(shape == Shape::wedge).known);
  });
  return 2 * told > faces;
}

unsigned CellsBeyond::sides_beyond(Shape shape, const Vec3d& r, double near) {
  const double far = 1.0 - near;
  if (is_brick(shape))
    return unsigned(r.x < near) | unsigned(r.x > far) << 1 | unsigned(r.y < near) << 2 |
           unsigned(r.y > far) << 3 | unsigned(r.z < near) << 4 | unsigned(r.z > far) << 5;
  if (shape == Shape::wedge)
    return unsigned(r.x < near) | unsigned(r.y < near) << 1 | unsigned(r.x + r.y > far) << 2 |
           unsigned(r.z < near) << 3 | unsigned(r.z > far) << 4;
  return 0;
}

int CellsBeyond::face_beyond(Shape shape, const Vec3d& r, double near) {
  double distance[6];
  const int faces = cells::parametric_distances(shape, r, distance);
  const double* const least = std::min_element(distance, distance + faces);
  return *least < near ? int(least - distance) : -1;
}

} // namespace insitu::advect

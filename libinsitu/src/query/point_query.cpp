#include "query/point_query.h"

#include <algorithm>
#include <cmath>
#include <span>
#include <vector>

#include "cells/kernels/kernels.h"
#include "query/batch/candidates.h"
#include "query/lattice/gridlet_query.h"

namespace insitu::query {

using math::Vec3d;

BoxRule::BoxRule(const Vec3d& origin_, double alpha, double moved) : origin(origin_) {
  if (alpha == 1.0 || moved == 0.0)
    return;
  // The blend's rounding, at the size of the coordinates, and that of the first term.
  wider_relative = 0x1p-50;
  wider = (1.0 - alpha) * moved * 1.0000001 + wider_relative * moved;
}

bool BoxRule::box(const Vec3d& p, float* lower, float* upper) const {
  bool finite = true;
  for (int a = 0; a < 3; ++a) {
    const double d = p[a] - origin[a], w = wider + wider_relative * std::fabs(p[a]);
    finite &= std::fabs(d) <= farthest;
    lower[a] = accel::round_down(d - w);
    upper[a] = accel::round_up(d + w);
  }
  return finite;
}

namespace {

bool meet(const accel::Box& b, const float* lower, const float* upper) {
  bool yes = true;
  for (int a = 0; a < 3; ++a)
    yes &= b.lower[a] <= upper[a] && lower[a] <= b.upper[a];
  return yes;
}

} // namespace

std::span<const Candidate> PointQuery::candidates_in(const float* lower, const float* upper) const {
  thread_local std::vector<Candidate> candidates;
  candidates.clear();
  std::uint32_t stack[64 * 8];
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const accel::Node& node = tree.nodes()[stack[--size]];
    for (int c = 0; c < 8; ++c) {
      if (!node.meta[c] || !meet(node.child_box(c), lower, upper))
        continue;
      if (node.is_inner(c)) {
        stack[size++] = node.child_node(c);
        continue;
      }
      for (int k = 0; k < node.child_cell_count(c); ++k)
        candidates.push_back(
            {node.child_cells(c) + std::uint32_t(k), 0, node.depth(c, lower, upper), 0});
    }
  }
  return candidates;
}

bool trying_pays(const mesh::MeshView& mesh) {
  if (gridlets_of(mesh))
    return true; // few cells lie outside of gridlets, and most of these are hexahedra
  return std::any_of(mesh.pieces, mesh.pieces + mesh.piece_count, [](const mesh::PieceView& cells) {
    return cells.layout != mesh::CellLayout::uniform ||
           cells.uniform_shape != mesh::Shape::tetrahedron;
  });
}

int PointQuery::tries() const {
  return proof().for_some() && options.alpha == 1.0 && trying_pays(mesh) ? 3 : 0;
}

/// The lowest of the candidates' cells in gridlets that hold p: the owner, since other cells have
/// higher ids.
Location PointQuery::locate_in_runs(std::span<const Candidate> candidates, const Vec3d& p,
                                    Reason& reason) const {
  const mesh::GridletsView* const gridlets = gridlets_of(mesh);
  Location best;
  for (const Candidate& c : candidates) {
    const std::int64_t flat = tree.cells()[c.slot];
    Reason why;
    if (flat >= mesh.first_cell[1] || (best && flat > best.cell))
      continue;
    const Location at = locate_in_gridlet(*gridlets, flat >> mesh::Gridlet::cell_bits, p, why);
    if (at && !(best && best.cell < at.cell)) {
      best = at;
      reason = why;
    }
  }
  return best;
}

Location PointQuery::locate(const Vec3d& p, Reason& reason) const {
  Location best;
  reason = Reason::outside;
  float lower[3], upper[3];
  if (tree.empty() || !box_rule().box(p, lower, upper))
    return best;
  const std::span<const Candidate> candidates = candidates_in(lower, upper);
  const std::uint32_t first = std::uint32_t(mesh.first_single_cell());
  if (first > 0)
    if (const Location at = locate_in_runs(candidates, p, reason))
      return at;
  mesh::CellVertices cell;
  std::uint64_t tried = ~std::uint64_t(0);
  int left = tries();
  if (!tree.odd().empty())
    for (const Candidate& c : candidates)
      if (tree.odd().has(c.slot))
        left = 0;
  for (; left > 0 && !best; --left) {
    std::uint64_t rank = 0; // no candidate's
    for (const Candidate& c : candidates)
      if (tree.cells()[c.slot] >= first)
        rank = std::max(rank, c.rank() < tried ? c.rank() : 0);
    if (rank == 0)
      break;
    tried = rank;
    const std::int64_t flat = tree.cells()[slot_of_rank(rank)];
    mesh::gather(mesh, flat, cell);
    const auto map = cells::inverse_map(cell.shape, cell.x, p);
    if (map.margin > map.error) {
      best = {flat, map.r};
      reason = Reason::certified;
    }
    if (is_on_boundary(map.margin, map.error))
      break;
  }
  if (best && proof().is_enough(best.cell))
    return best;
  mesh::CellVertices owner;
  cells::Decision decision;
  bool located = bool(best);
  for (const Candidate& c : candidates) {
    const std::int64_t flat = tree.cells()[c.slot];
    if (flat < first || (best && flat >= best.cell))
      continue;
    mesh::gather(mesh, flat, cell, options.alpha);
    if (const cells::Decision why = decide(cell.shape, cell.x, p)) {
      best.cell = flat;
      decision = why;
      reason = why.reason();
      owner = cell;
      located = false;
    }
  }
  if (best && !located)
    best.parametric = parametric_in(owner.shape, owner.x, p, decision);
  return best;
}

} // namespace insitu::query

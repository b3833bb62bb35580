#include "commit/checks/overlaps.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <memory>
#include <vector>

#include "cells/kernels/kernels.h"
#include "mesh/piece_borders.h"
#include "query/batch/candidates.h"
#include "query/point_query.h"

namespace insitu::commit {

namespace {

using math::Vec3d;

/// Whether a vertex at p, none of the cell's, is in the closed cell, as far as rounding tells.
bool reaches(const mesh::CellVertices& cell, const Vec3d& p) {
  constexpr double near = 1e-9;
  if (const auto map = cells::inverse_map(cell.shape, cell.x, p); map.converged)
    return map.margin >= -near;
  return bool(cells::decide(cell.shape, cell.x, p));
}

std::vector<std::int64_t> boundary_vertices(const accel::MeshFaces& faces) {
  std::vector<std::int64_t> vertices;
  vertices.reserve(4 * std::size_t(faces.boundary_faces()));
  for (const accel::MeshFaces::Face& face : faces.faces())
    if (face.other == accel::none)
      std::copy_if(face.vertices, face.vertices + 4, std::back_inserter(vertices),
                   [](std::uint32_t v) { return v != accel::none; });
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

/// What a batch of vertices needs.
struct Batch {
  query::QueryBoxes boxes;
  query::TraversalScratch traversal;
  Vec3d points[query::batch_size];
};

/// Whether one of `count` points reaches into a cell that is not its own: point(i), and
/// own(cell, i, point), which tells the cells that do not count.
template <class Point, class Own>
bool any_reaches(const mesh::MeshView& mesh, const accel::Tree& tree, std::int64_t count,
                 const core::Threads& threads, const Point& point, const Own& own) {
  const query::BoxRule rule(tree.origin());
  std::atomic<bool> overlap{false};
  threads.parallel_for(count, query::batch_size, [&](std::int64_t begin, std::int64_t end) {
    if (overlap)
      return;
    const auto batch = std::make_unique<Batch>(); // too large for a thread's stack
    const auto n = std::size_t(end - begin);
    for (std::size_t q = 0; q < n; ++q)
      batch->points[q] = point(begin + std::int64_t(q));
    set_boxes(rule, {batch->points, n}, batch->boxes);
    query::find_candidates(tree, batch->boxes, batch->traversal);
    mesh::CellVertices cell;
    for (std::size_t c = 0; c < batch->traversal.found && !overlap; ++c) {
      const query::Candidate& candidate = batch->traversal.candidates[c];
      mesh::gather(mesh, std::int64_t(tree.cells()[candidate.slot]), cell);
      const Vec3d& p = batch->points[candidate.query];
      if (!own(cell, begin + candidate.query, p) && reaches(cell, p))
        overlap = true;
    }
  });
  return overlap;
}

} // namespace

bool covers_once(const mesh::MeshView& mesh, const accel::MeshFaces& faces, const accel::Tree& tree,
                 const core::Threads& threads) {
  if (mesh.piece_count != 1 || !mesh.free_of_folds || tree.empty() || faces.crowded_faces() > 0 ||
      faces.turned_faces() > 0 || faces.split_faces() > 0)
    return false;
  const std::vector<std::int64_t> vertices = boundary_vertices(faces);
  return !any_reaches(
      mesh, tree, std::int64_t(vertices.size()), threads,
      [&](std::int64_t i) { return mesh.pieces[0].point(vertices[std::size_t(i)]); },
      [&](const mesh::CellVertices& cell, std::int64_t i, const Vec3d&) {
        return std::find(cell.ids, cell.ids + cell.count, vertices[std::size_t(i)]) !=
               cell.ids + cell.count;
      });
}

bool pieces_are_apart(const mesh::MeshView& mesh, const accel::Tree& tree,
                      const core::Threads& threads) {
  const auto [vertices, cells] =
      mesh::find_among_others(mesh, mesh::Boxes::share_interior, true, threads);
  const auto piece_of = [&](std::int64_t vertex) { return mesh::piece_of_vertex(mesh, vertex); };
  const auto vertices_reach = [&, &vertices = vertices] {
    return any_reaches(
        mesh, tree, std::int64_t(vertices.size()), threads,
        [&](std::int64_t i) {
          const std::int64_t v = vertices[std::size_t(i)];
          return mesh.pieces[piece_of(v)].point(v - mesh.first_vertex[piece_of(v)]);
        },
        [&](const mesh::CellVertices& cell, std::int64_t i, const Vec3d& x) {
          return cell.piece == piece_of(vertices[std::size_t(i)]) ||
                 std::find(cell.x, cell.x + cell.count, x) != cell.x + cell.count;
        });
  };
  const auto cells_reach = [&, &cells = cells] {
    return any_reaches(
        mesh, tree, std::int64_t(cells.size()), threads,
        [&](std::int64_t i) {
          mesh::CellVertices cell;
          mesh::gather(mesh, cells[std::size_t(i)], cell);
          return mesh::middle_of(cell);
        },
        [&](const mesh::CellVertices& cell, std::int64_t i, const Vec3d&) {
          return cell.piece == mesh.piece_of(cells[std::size_t(i)]);
        });
  };
  return !cells_reach() && !vertices_reach();
}

} // namespace insitu::commit

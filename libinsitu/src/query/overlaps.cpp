#include "query/overlaps.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <memory>
#include <vector>

#include "cells/kernels.h"
#include "mesh/piece_borders.h"
#include "query/candidates.h"
#include "query/point_query.h"

namespace insitu::query {

namespace {

using math::Vec3d;

/// Whether a vertex at p, none of the cell's, is in the closed cell, as far as rounding tells.
bool reaches(const mesh::CellVertices& cell, const Vec3d& p) {
  constexpr double near = 1e-9;
  if (const auto map = cells::inverse_map(cell.shape, cell.x, p); map.converged)
    return map.margin >= -near;
  return bool(decide(cell.shape, cell.x, p));
}

Vec3d point_of(const mesh::MeshView& mesh, std::int64_t flat) {
  const std::int32_t piece = mesh::piece_of_vertex(mesh, flat);
  return mesh.pieces[piece].point(flat - mesh.first_vertex[piece]);
}

std::vector<std::int64_t> boundary_vertices(const accel::FaceTable& faces) {
  std::vector<std::int64_t> vertices;
  vertices.reserve(4 * std::size_t(faces.boundary_faces()));
  for (const accel::FaceTable::Face& face : faces.faces())
    if (face.other == accel::none)
      std::copy_if(face.vertices, face.vertices + 4, std::back_inserter(vertices),
                   [](std::uint32_t v) { return v != accel::none; });
  std::sort(vertices.begin(), vertices.end());
  vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
  return vertices;
}

/// What a batch of vertices needs.
struct Batch {
  QueryBoxes boxes;
  TraversalScratch traversal;
  Vec3d points[batch_size];
};

/// Whether a vertex reaches into a cell that is not its own: own(cell, flat vertex) tells those
/// that do not count.
template <class Own>
bool any_reaches(const mesh::MeshView& mesh, const accel::Tree& tree,
                 const std::vector<std::int64_t>& flat_vertices, const core::Threads& threads,
                 const Own& own) {
  const BoxRule rule(tree.origin());
  std::atomic<bool> overlap{false};
  threads.parallel_for(
      std::int64_t(flat_vertices.size()), batch_size, [&](std::int64_t begin, std::int64_t end) {
        if (overlap)
          return;
        const auto batch = std::make_unique<Batch>(); // too large for a thread's stack
        const std::int64_t* vertices = flat_vertices.data() + begin;
        const auto n = std::size_t(end - begin);
        for (std::size_t q = 0; q < n; ++q)
          batch->points[q] = point_of(mesh, vertices[q]);
        set_boxes(rule, {batch->points, n}, batch->boxes);
        find_candidates(tree, batch->boxes, batch->traversal);
        mesh::CellVertices cell;
        for (std::size_t c = 0; c < batch->traversal.found && !overlap; ++c) {
          const Candidate& candidate = batch->traversal.candidates[c];
          mesh::gather(mesh, std::int64_t(tree.cells()[candidate.slot]), cell);
          const Vec3d& p = batch->points[candidate.query];
          if (!own(cell, vertices[candidate.query], p) && reaches(cell, p))
            overlap = true;
        }
      });
  return overlap;
}

} // namespace

bool covers_once(const mesh::MeshView& mesh, const accel::FaceTable& faces, const accel::Tree& tree,
                 const core::Threads& threads) {
  if (mesh.piece_count != 1 || !mesh.free_of_folds || tree.empty() || faces.crowded_faces() > 0 ||
      faces.turned_faces() > 0 || faces.split_faces() > 0)
    return false;
  return !any_reaches(mesh, tree, boundary_vertices(faces), threads,
                      [](const mesh::CellVertices& cell, std::int64_t vertex, const Vec3d&) {
                        return std::find(cell.ids, cell.ids + cell.count, vertex) !=
                               cell.ids + cell.count;
                      });
}

bool pieces_are_apart(const mesh::MeshView& mesh, const accel::Tree& tree,
                      const core::Threads& threads) {
  const std::vector<std::int64_t> vertices =
      mesh::vertices_in_other_boxes(mesh, mesh::Boxes::share_interior, threads);
  return std::int64_t(vertices.size()) <= mesh.vertex_count() / 4 &&
         !any_reaches(mesh, tree, vertices, threads,
                      [&](const mesh::CellVertices& cell, std::int64_t vertex, const Vec3d& x) {
                        return cell.piece == mesh::piece_of_vertex(mesh, vertex) ||
                               std::find(cell.x, cell.x + cell.count, x) != cell.x + cell.count;
                      });
}

} // namespace insitu::query

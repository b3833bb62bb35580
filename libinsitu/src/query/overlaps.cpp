#include "query/overlaps.h"

#include <algorithm>
#include <atomic>
#include <iterator>
#include <memory>
#include <vector>

#include "cells/kernels.h"
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

std::vector<std::uint32_t> boundary_vertices(const accel::FaceTable& faces) {
  std::vector<std::uint32_t> vertices;
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

} // namespace

bool covers_once(const mesh::MeshView& mesh, const accel::FaceTable& faces, const accel::Tree& tree,
                 const core::Threads& threads) {
  if (mesh.piece_count != 1 || !mesh.free_of_folds || tree.empty() || faces.crowded_faces() > 0 ||
      faces.turned_faces() > 0 || faces.split_faces() > 0)
    return false;
  const std::vector<std::uint32_t> vertices = boundary_vertices(faces);
  const BoxRule rule(tree.origin());
  std::atomic<bool> overlap{false};
  threads.parallel_for(
      std::int64_t(vertices.size()), batch_size, [&](std::int64_t begin, std::int64_t end) {
        if (overlap)
          return;
        const auto batch = std::make_unique<Batch>(); // too large for a thread's stack
        const std::uint32_t* ids = vertices.data() + begin;
        const auto n = std::size_t(end - begin);
        for (std::size_t q = 0; q < n; ++q)
          batch->points[q] = mesh.pieces[0].point(ids[q]);
        set_boxes(rule, {batch->points, n}, batch->boxes);
        find_candidates(tree, batch->boxes, batch->traversal);
        mesh::CellVertices cell;
        for (std::size_t c = 0; c < batch->traversal.found && !overlap; ++c) {
          const Candidate& candidate = batch->traversal.candidates[c];
          mesh::gather(mesh, std::int64_t(tree.cells()[candidate.slot]), cell);
          const std::int64_t *first = cell.ids, *last = first + cell.count;
          if (std::find(first, last, std::int64_t(ids[candidate.query])) == last &&
              reaches(cell, batch->points[candidate.query]))
            overlap = true;
        }
      });
  return !overlap;
}

} // namespace insitu::query

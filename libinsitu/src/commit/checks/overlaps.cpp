#include "commit/checks/overlaps.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <iterator>
#include <limits>
#include <memory>
#include <mutex>
#include <vector>

#include "cells/kernels/kernels.h"
#include "mesh/piece_borders.h"
#include "query/batch/candidates.h"
#include "query/point_query.h"

namespace insitu::commit {

namespace {

using math::Vec3d;

/// Roundings of places in a cell, in its own units.
constexpr double near = 1e-9;

/// How far p, which is none of the cell's vertices, lies within the cell, in the cell's own units;
/// negative: outside.
double depth(const mesh::CellVertices& cell, const Vec3d& p) {
  if (const auto map = cells::inverse_map(cell.shape, cell.x, p); map.converged)
    return map.margin;
  return cells::decide(cell.shape, cell.x, p) ? 0.0 : -1.0;
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

/// What points reach into: cells that are not their own. Several threads add to it.
class Reached {
public:
  /// at_depth: a point that lies deeper in a cell is told with that cell. Where it is infinite the
  /// first one that touches a cell ends the search.
  explicit Reached(double at_depth) : at_depth_(at_depth) {}

  bool any() const { return any_; }
  /// No point from this one on makes a difference.
  bool is_settled(std::int64_t point) const {
    return std::isinf(at_depth_) ? any_.load() : point > first_.load();
  }
  void add(std::int64_t point, std::int64_t cell, double depth) {
    any_ = true;
    if (!(depth > at_depth_))
      return;
    const std::lock_guard lock(mutex_);
    if (point < first_ || (point == first_ && cell < cell_)) {
      first_ = point;
      cell_ = cell;
    }
  }
  /// The first point that lies so deep, and the lowest cell that it lies in.
  struct Pair {
    std::int64_t point, cell;
  };
  std::optional<Pair> first() const {
    return cell_ < 0 ? std::nullopt : std::optional(Pair{first_, cell_});
  }

private:
  double at_depth_;
  std::atomic<bool> any_{false};
  std::atomic<std::int64_t> first_{std::numeric_limits<std::int64_t>::max()};
  std::int64_t cell_ = -1;
  std::mutex mutex_;
};

/// Looks which of `count` points reach into cells: point(i), and own(cell, i, point), which tells
/// the cells that do not count.
template <class Point, class Own>
void look(const mesh::MeshView& mesh, const accel::Tree& tree, std::int64_t count,
          const core::Threads& threads, const Point& point, const Own& own, Reached& reached) {
  const query::BoxRule rule(tree.origin());
  threads.parallel_for(count, query::batch_size, [&](std::int64_t begin, std::int64_t end) {
    if (reached.is_settled(begin))
      return;
    const auto batch = std::make_unique<Batch>(); // too large for a thread's stack
    const auto n = std::size_t(end - begin);
    for (std::size_t q = 0; q < n; ++q)
      batch->points[q] = point(begin + std::int64_t(q));
    set_boxes(rule, {batch->points, n}, batch->boxes);
    query::find_candidates(tree, batch->boxes, batch->traversal);
    mesh::CellVertices cell;
    for (std::size_t c = 0; c < batch->traversal.found; ++c) {
      const query::Candidate& candidate = batch->traversal.candidates[c];
      const std::int64_t i = begin + candidate.query;
      if (reached.is_settled(i))
        continue;
      const auto flat = std::int64_t(tree.cells()[candidate.slot]);
      mesh::gather(mesh, flat, cell);
      const Vec3d& p = batch->points[candidate.query];
      if (own(cell, i, p))
        continue;
      if (const double d = depth(cell, p); d >= -near)
        reached.add(i, flat, d);
    }
  });
}

/// The lowest cell of its piece that has the vertex and owns points.
std::int64_t cell_of_vertex(const mesh::MeshView& mesh, std::int64_t flat) {
  const std::int32_t p = mesh::piece_of_vertex(mesh, flat);
  const mesh::PieceView& piece = mesh.pieces[p];
  std::int64_t ids[8];
  for (std::int64_t cell = 0; cell < piece.cell_count; ++cell) {
    if (!piece.exists(cell))
      continue;
    const int n = piece.vertex_ids(cell, ids);
    if (std::find(ids, ids + n, flat - mesh.first_vertex[p]) != ids + n)
      return mesh.first_cell[p] + cell;
  }
  return -1;
}

} // namespace

bool covers_once(const mesh::MeshView& mesh, const accel::MeshFaces& faces, const accel::Tree& tree,
                 const core::Threads& threads) {
  if (mesh.piece_count != 1 || !mesh.free_of_folds || tree.empty() || faces.crowded_faces() > 0 ||
      faces.turned_faces() > 0 || faces.split_faces() > 0)
    return false;
  const std::vector<std::int64_t> vertices = boundary_vertices(faces);
  Reached reached(std::numeric_limits<double>::infinity());
  look(
      mesh, tree, std::int64_t(vertices.size()), threads,
      [&](std::int64_t i) { return mesh.pieces[0].point(vertices[std::size_t(i)]); },
      [&](const mesh::CellVertices& cell, std::int64_t i, const Vec3d&) {
        return std::find(cell.ids, cell.ids + cell.count, vertices[std::size_t(i)]) !=
               cell.ids + cell.count;
      },
      reached);
  return !reached.any();
}

PiecesApart look_at_pieces(const mesh::MeshView& mesh, const accel::Tree& tree,
                           const core::Threads& threads) {
  const auto [vertices, cells] =
      mesh::find_among_others(mesh, mesh::Boxes::share_interior, true, threads);
  PiecesApart found;
  const auto tell = [&](std::int64_t a, std::int64_t b) {
    found.overlap = PiecesApart::Overlap{std::min(a, b), std::max(a, b)};
  };
  Reached by_cells(near);
  look(
      mesh, tree, std::int64_t(cells.size()), threads,
      [&, &cells = cells](std::int64_t i) {
        mesh::CellVertices cell;
        mesh::gather(mesh, cells[std::size_t(i)], cell);
        return mesh::middle_of(cell);
      },
      [&, &cells = cells](const mesh::CellVertices& cell, std::int64_t i, const Vec3d&) {
        return cell.piece == mesh.piece_of(cells[std::size_t(i)]);
      },
      by_cells);
  if (const auto first = by_cells.first()) {
    tell(cells[std::size_t(first->point)], first->cell);
    return found;
  }
  const auto piece_of = [&](std::int64_t vertex) { return mesh::piece_of_vertex(mesh, vertex); };
  Reached by_vertices(PiecesApart::depth);
  look(
      mesh, tree, std::int64_t(vertices.size()), threads,
      [&, &vertices = vertices](std::int64_t i) {
        const std::int64_t v = vertices[std::size_t(i)];
        return mesh.pieces[piece_of(v)].point(v - mesh.first_vertex[piece_of(v)]);
      },
      [&, &vertices = vertices](const mesh::CellVertices& cell, std::int64_t i, const Vec3d& x) {
        return cell.piece == piece_of(vertices[std::size_t(i)]) ||
               std::find(cell.x, cell.x + cell.count, x) != cell.x + cell.count;
      },
      by_vertices);
  if (const auto first = by_vertices.first())
    tell(cell_of_vertex(mesh, vertices[std::size_t(first->point)]), first->cell);
  found.apart = !by_cells.any() && !by_vertices.any();
  return found;
}

} // namespace insitu::commit

#include "query/sampler.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>

#include "accel/tree.h"
#include "cells/contain_exact.h"
#include "cells/kernels.h"
#include "cells/robust_inverse.h"
#include "query/candidates.h"
#include "query/cell_source.h"

namespace insitu::query {

namespace {

using math::Vec3d;

/// Where Newton's parametric coordinates are closer than this to the cell's boundary, the exact
/// test decides. Newton errs by rounding times the condition of the map: 1e-6 serves conditions up
/// to 1e9.
constexpr double tie_zone = 1e-6;

/// Whether the closed cell holds p, given what the inverse map said; r: where.
bool holds(mesh::Shape shape, const Vec3d* x, const Vec3d& p, const cells::InverseMap<double>& map,
           insitu_accuracy accuracy, Vec3d& r) {
  r = map.r;
  // Exactly, Newton proves nothing: a folded cell may map to p and surround it twice.
  if (accuracy != INSITU_EXACT && map.converged && map.margin > tie_zone)
    return true;
  if (accuracy != INSITU_EXACT && map.converged && map.margin < -tie_zone)
    return false;
  if (!cells::holds(cells::contain_exact(shape, x, p).where))
    return false;
  if (!map.converged || map.margin < -1e-3)
    r = cells::robust_inverse(shape, x, p);
  return true;
}

struct Query {
  const mesh::MeshView& mesh;
  const accel::Tree& tree;
  LocateOptions options;

  /// The query's box in the tree's frame, rounded outwards; wider while the mesh is between two
  /// steps, since boxes hold the current one. False for points that are not finite.
  bool box(const Vec3d& p, float* lower, float* upper) const {
    const double moved = options.alpha == 1.0 ? 0.0 : mesh.largest_displacement;
    for (int a = 0; a < 3; ++a) {
      const double d = p[a] - tree.origin()[a];
      // The second term is the blend's rounding, at the size of the coordinates.
      const double wider = moved == 0.0 ? 0.0
                                        : (1.0 - options.alpha) * moved * 1.0000001 +
                                              0x1p-50 * (std::fabs(p[a]) + moved);
      if (!(std::fabs(d) <= 3e37))
        return false;
      lower[a] = accel::round_down(d - wider);
      upper[a] = accel::round_up(d + wider);
    }
    return true;
  }

  /// Tries one cell; keeps the lowest id in `best`.
  void try_cell(std::int64_t flat, const Vec3d& p, Location& best) const {
    if (best.cell >= 0 && flat >= best.cell)
      return;
    mesh::CellVertices cell;
    mesh::gather(mesh, flat, cell, options.alpha);
    const auto map = cells::inverse_map(cell.shape, cell.x, p);
    Vec3d r;
    if (holds(cell.shape, cell.x, p, map, options.accuracy, r))
      best = {flat, r};
  }

  /// The exact test alone: for points that no candidate claimed, since Newton may have run to
  /// another preimage outside a strongly twisted cell that holds the point.
  void try_cell_exactly(std::int64_t flat, const Vec3d& p, Location& best) const {
    if (best.cell >= 0 && flat >= best.cell)
      return;
    mesh::CellVertices cell;
    mesh::gather(mesh, flat, cell, options.alpha);
    if (cells::holds(cells::contain_exact(cell.shape, cell.x, p).where))
      best = {flat, cells::robust_inverse(cell.shape, cell.x, p)};
  }

  template <class Visit>
  void for_each_candidate(const float* lower, const float* upper, Visit&& visit) const {
    std::uint32_t stack[64 * 8];
    int size = 0;
    stack[size++] = 0;
    while (size > 0) {
      const accel::Node& node = tree.nodes()[stack[--size]];
      for (int c = 0; c < 8; ++c) {
        if (!node.meta[c])
          continue;
        const accel::Box b = node.child_box(c);
        if (!(b.lower[0] <= upper[0] && lower[0] <= b.upper[0] && b.lower[1] <= upper[1] &&
              lower[1] <= b.upper[1] && b.lower[2] <= upper[2] && lower[2] <= b.upper[2]))
          continue;
        if (node.is_inner(c))
          stack[size++] = node.child_node(c);
        else
          for (int k = 0; k < node.child_cell_count(c); ++k)
            visit(std::int64_t(tree.cells()[node.child_cells(c) + std::uint32_t(k)]));
      }
    }
  }

  Location locate(const Vec3d& p) const {
    Location best;
    float lower[3], upper[3];
    if (tree.empty() || !box(p, lower, upper))
      return best;
    for_each_candidate(lower, upper, [&](std::int64_t flat) { try_cell(flat, p, best); });
    if (!best && options.accuracy != INSITU_EXACT)
      for_each_candidate(lower, upper, [&](std::int64_t flat) { try_cell_exactly(flat, p, best); });
    return best;
  }
};

/// What one thread needs for batches; kept for the thread's life, since it is small.
struct BatchScratch {
  QueryBoxes boxes;
  TraversalScratch traversal;
  std::vector<std::int64_t> cells;
  std::uint32_t index[batch_size]; ///< query -> point
  InverseBlock block;
  Candidate pairs[block_size];
};

class BatchLocator {
public:
  BatchLocator(const Query& query, std::span<const Vec3d> points, std::span<Location> out,
               BatchScratch& scratch)
      : query_(query), points_(points), out_(out), s_(scratch) {}

  void run() {
    s_.boxes.count = 0;
    for (std::size_t i = 0; i < points_.size(); ++i) {
      out_[i] = {};
      const int q = s_.boxes.count;
      float lower[3], upper[3];
      if (!query_.box(points_[i], lower, upper))
        continue;
      s_.boxes.set(q, lower, upper);
      s_.index[q] = std::uint32_t(i);
      ++s_.boxes.count;
    }
    find_candidates(query_.tree, s_.boxes, s_.traversal);
    with_cells(query_.mesh, query_.options.alpha, [&](const auto& source) { decide(source); });
    if (query_.options.accuracy != INSITU_EXACT)
      for (std::size_t c = 0; c < s_.traversal.found; ++c) {
        const std::uint32_t i = s_.index[s_.traversal.candidates[c].query];
        if (!out_[i] || unclaimed_[i])
          retry(c, i);
      }
  }

private:
  template <class Source>
  void decide(const Source& source) {
    const std::size_t found = s_.traversal.found;
    const Candidate* candidates = s_.traversal.candidates.data();
    if (s_.cells.size() < found)
      s_.cells.resize(2 * found);
    for (std::size_t c = 0; c < found; ++c) {
      s_.cells[c] = std::int64_t(query_.tree.cells()[candidates[c].slot]);
      source.prefetch_ids(s_.cells[c]);
    }
    constexpr std::size_t ahead = 24; // vertices are asked for so many candidates early
    for (std::size_t c = 0; c < std::min(found, ahead); ++c)
      source.prefetch_points(s_.cells[c]);

    unsigned shapes = 0; // bit per shape met, so that each gets blocks of its own
    for (std::size_t c = 0; c < found; ++c) {
      if (c + ahead < found)
        source.prefetch_points(s_.cells[c + ahead]);
      const mesh::Shape shape = source.shape(s_.cells[c]);
      shapes |= 1u << int(shape);
      if (shapes != (1u << int(shape))) {
        // A second shape: the rest of this batch goes one by one through the shape passes below.
        break;
      }
      add(source, shape, candidates[c], s_.cells[c]);
    }
    if (std::popcount(shapes) <= 1) {
      if (shapes)
        flush(mesh::Shape(std::countr_zero(shapes)));
      return;
    }
    s_.block.count = 0;
    for (int shape = 10; shape <= 14; ++shape) {
      for (std::size_t c = 0; c < found; ++c)
        if (source.shape(s_.cells[c]) == mesh::Shape(shape))
          add(source, mesh::Shape(shape), candidates[c], s_.cells[c]);
      flush(mesh::Shape(shape));
    }
  }

  template <class Source>
  void add(const Source& source, mesh::Shape shape, const Candidate& candidate, std::int64_t cell) {
    InverseBlock& b = s_.block;
    const int at = b.count++;
    source.gather(cell, [&](int v, const Vec3d& x) {
      b.vertex[v][0][at] = x.x;
      b.vertex[v][1][at] = x.y;
      b.vertex[v][2][at] = x.z;
    });
    const Vec3d& p = points_[s_.index[candidate.query]];
    b.point[0][at] = p.x;
    b.point[1][at] = p.y;
    b.point[2][at] = p.z;
    s_.pairs[at] = {std::uint32_t(cell), candidate.query};
    if (b.count == block_size)
      flush(shape);
  }

  void flush(mesh::Shape shape) {
    InverseBlock& b = s_.block;
    if (b.count == 0)
      return;
    invert(shape, b);
    // Sorted first, without branches that half of the candidates would take: certainly inside,
    // certainly outside, or to be looked at again.
    const bool exact = query_.options.accuracy == INSITU_EXACT;
    std::uint8_t inside[block_size], unsure[block_size];
    int inside_count = 0, unsure_count = 0;
    for (int k = 0; k < b.count; ++k) {
      const bool converged = b.converged[k] != 0.0;
      const bool in = converged & (b.margin[k] > tie_zone) & !exact;
      const bool out = converged & (b.margin[k] < -tie_zone) & !exact;
      inside[inside_count] = unsure[unsure_count] = std::uint8_t(k);
      inside_count += in;
      unsure_count += !(in | out);
    }
    for (int n = 0; n < inside_count; ++n) {
      const int k = inside[n];
      claim(k, {b.parametric[0][k], b.parametric[1][k], b.parametric[2][k]});
    }
    for (int n = 0; n < unsure_count; ++n) {
      const int k = unsure[n];
      Vec3d x[8], r;
      for (int v = 0; v < mesh::vertex_count(shape); ++v)
        x[v] = {b.vertex[v][0][k], b.vertex[v][1][k], b.vertex[v][2][k]};
      const cells::InverseMap<double> map{
          {b.parametric[0][k], b.parametric[1][k], b.parametric[2][k]},
          b.margin[k],
          b.converged[k] != 0.0};
      const Vec3d& p = points_[s_.index[s_.pairs[k].query]];
      if (holds(shape, x, p, map, query_.options.accuracy, r))
        claim(k, r);
    }
    b.count = 0;
  }

  /// The block's pair k: the cell holds the point at r. The lowest id stays.
  void claim(int k, const Vec3d& r) {
    Location& best = out_[s_.index[s_.pairs[k].query]];
    const auto flat = std::int64_t(s_.pairs[k].slot);
    if (best.cell < 0 || flat < best.cell)
      best = {flat, r};
  }

  void retry(std::size_t candidate, std::uint32_t i) {
    unclaimed_[i] = true;
    query_.try_cell_exactly(s_.cells[candidate], points_[i], out_[i]);
  }

  const Query& query_;
  std::span<const Vec3d> points_;
  std::span<Location> out_;
  BatchScratch& s_;
  bool unclaimed_[batch_size] = {}; ///< no candidate claimed the point at first
};

BatchScratch& batch_scratch() {
  thread_local std::unique_ptr<BatchScratch> scratch = std::make_unique<BatchScratch>();
  return *scratch;
}

} // namespace

Location Sampler::locate(const Vec3d& p, std::int64_t hint, const LocateOptions& options) const {
  if (hint >= 0 && mesh_->free_of_folds && hint < mesh_->cell_count() &&
      mesh_->pieces[0].owns(hint)) { // free_of_folds implies one piece
    mesh::CellVertices cell;
    mesh::gather(*mesh_, hint, cell, options.alpha);
    const auto map = cells::inverse_map(cell.shape, cell.x, p);
    if (map.converged && map.margin > tie_zone &&
        (options.accuracy != INSITU_EXACT ||
         cells::contain_exact(cell.shape, cell.x, p).where == cells::Containment::inside))
      return {hint, map.r};
  }
  return Query{*mesh_, *tree_, options}.locate(p);
}

void Sampler::locate_serial(std::span<const Vec3d> points, std::span<Location> locations,
                            const LocateOptions& options) const {
  if (tree_->empty()) {
    std::fill(locations.begin(), locations.end(), Location{});
    return;
  }
  const Query query{*mesh_, *tree_, options};
  BatchScratch& scratch = batch_scratch();
  for (std::size_t first = 0; first < points.size(); first += batch_size) {
    const std::size_t n = std::min<std::size_t>(batch_size, points.size() - first);
    BatchLocator(query, points.subspan(first, n), locations.subspan(first, n), scratch).run();
  }
}

void Sampler::locate(const core::Threads& threads, std::span<const Vec3d> points,
                     std::span<Location> locations, const LocateOptions& options) const {
  threads.parallel_for(
      std::int64_t(points.size()), 16 * batch_size, [&](std::int64_t begin, std::int64_t end) {
        locate_serial(points.subspan(std::size_t(begin), std::size_t(end - begin)),
                      locations.subspan(std::size_t(begin), std::size_t(end - begin)), options);
      });
}

void Sampler::interpolate(const mesh::FieldView& field, const Location& at, double* values) const {
  interpolate(std::span(&field, 1), at, values);
}

void Sampler::interpolate(std::span<const mesh::FieldView> fields, const Location& at,
                          double* values) const {
  const std::int32_t piece = mesh_->piece_count == 1 ? 0 : mesh_->piece_of(at.cell);
  const mesh::PieceView& cells_of = mesh_->pieces[piece];
  const std::int64_t cell = at.cell - mesh_->first_cell[piece];
  double weight[8];
  std::int64_t ids[8];
  int n = 0;
  for (const mesh::FieldView& field : fields) {
    const mesh::FieldPieceView& from = field.pieces[piece];
    if (field.association == INSITU_CELL) {
      for (int c = 0; c < field.components; ++c)
        *values++ = from.load(cell, c);
      continue;
    }
    if (n == 0) {
      n = cells_of.vertex_ids(cell, ids);
      cells::shape_functions(cells_of.shape(cell), at.parametric, weight);
    }
    for (int c = 0; c < field.components; ++c) {
      double sum = weight[0] * from.load(ids[0], c);
      for (int v = 1; v < n; ++v)
        sum += weight[v] * from.load(ids[v], c);
      *values++ = sum;
    }
  }
}

Vec3d Sampler::gradient(const mesh::FieldView& field, int component, const Location& at,
                        double alpha) const {
  if (field.association == INSITU_CELL)
    return {};
  mesh::CellVertices cell;
  mesh::gather(*mesh_, at.cell, cell, alpha);
  double f[8];
  for (int v = 0; v < cell.count; ++v)
    f[v] = field.pieces[cell.piece].load(cell.ids[v], component);
  return cells::gradient(cell.shape, cell.x, f, at.parametric);
}

} // namespace insitu::query

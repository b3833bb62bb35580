#include "commit/checks/hanging_vertices.h"

#include <algorithm>
#include <atomic>
#include <memory>
#include <vector>

#include "accel/tree/tree.h"
#include "cells/kernels/kernels.h"
#include "query/batch/candidates.h"

namespace insitu::commit {

namespace {

using math::Vec3d;

enum class Touch : std::uint8_t { none, hanging, covered };

/// How a vertex at p touches the cell, if it is none of its corners.
Touch touch(const mesh::CellVertices& cell, const Vec3d& p) {
  if (std::find(cell.x, cell.x + cell.count, p) != cell.x + cell.count)
    return Touch::none;
  constexpr double near = 1e-9; // rounding, also far from zero; neighbours 1e9 times as thin differ
  if (const auto map = cells::inverse_map(cell.shape, cell.x, p); map.converged)
    return map.margin < -near ? Touch::none : map.margin <= near ? Touch::hanging : Touch::covered;
  const query::Reason why = cells::decide(cell.shape, cell.x, p).reason();
  if (why == query::Reason::outside)
    return Touch::none;
  return why == query::Reason::certified || why == query::Reason::exact ? Touch::covered
                                                                        : Touch::hanging;
}

/// One byte a vertex, 1 if a cell that owns points has it.
std::vector<std::uint8_t> used_vertices(const mesh::MeshView& mesh, const core::Threads& threads) {
  std::vector<std::uint8_t> used(std::size_t(mesh.vertex_count()), 0);
  threads.parallel_for(mesh.cell_count(), 4096, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t flat = begin; flat < end; ++flat) {
      const std::int32_t piece = mesh.piece_of(flat);
      const std::int64_t cell = flat - mesh.first_cell[piece];
      if (!mesh.pieces[piece].exists(cell))
        continue;
      std::int64_t ids[8];
      const int n = mesh.pieces[piece].vertex_ids(cell, ids);
      for (int v = 0; v < n; ++v) // several cells store the same number
        std::atomic_ref(used[std::size_t(mesh.first_vertex[piece] + ids[v])])
            .store(1, std::memory_order_relaxed);
    }
  });
  return used;
}

/// A batch of vertices and what they touch.
class Batch {
public:
  explicit Batch(const mesh::MeshView& mesh, const accel::Tree& tree)
      : mesh_(mesh), tree_(tree), rule_(tree.origin()) {}

  void add(const Vec3d& p, HangingVertices& sum) {
    points_[count_++] = p;
    if (count_ == query::batch_size)
      run(sum);
  }

  void run(HangingVertices& sum) {
    set_boxes(rule_, {points_, std::size_t(count_)}, boxes_);
    query::find_candidates(tree_, boxes_, traversal_);
    Touch most[query::batch_size] = {};
    mesh::CellVertices cell;
    for (std::size_t c = 0; c < traversal_.found; ++c) {
      const query::Candidate& candidate = traversal_.candidates[c];
      Touch& of = most[candidate.query];
      if (of == Touch::covered) // nothing more to find; where many cells overlap this saves most
        continue;
      mesh::gather(mesh_, std::int64_t(tree_.cells()[candidate.slot]), cell);
      of = std::max(of, touch(cell, points_[candidate.query]));
    }
    sum.hanging += std::count(most, most + count_, Touch::hanging);
    sum.covered += std::count(most, most + count_, Touch::covered);
    count_ = 0;
  }

private:
  const mesh::MeshView& mesh_;
  const accel::Tree& tree_;
  query::BoxRule rule_;
  query::QueryBoxes boxes_;
  query::TraversalScratch traversal_;
  int count_ = 0;
  Vec3d points_[query::batch_size];
};

} // namespace

HangingVertices find_hanging_vertices(const mesh::MeshView& mesh, const core::Threads& threads) {
  core::Memory memory;
  accel::Tree tree(memory);
  tree.build(mesh, threads, accel::Builder::morton);
  const std::vector<std::uint8_t> used = used_vertices(mesh, threads);
  std::atomic<std::int64_t> hanging{0}, covered{0};
  threads.parallel_for(
      mesh.vertex_count(), 16 * query::batch_size, [&](std::int64_t begin, std::int64_t end) {
        const auto batch = std::make_unique<Batch>(mesh, tree); // too large for a thread's stack
        HangingVertices sum;
        std::int32_t piece = 0;
        for (std::int64_t v = begin; v < end; ++v) {
          while (piece + 1 < mesh.piece_count && v >= mesh.first_vertex[piece + 1])
            ++piece;
          if (used[std::size_t(v)])
            batch->add(mesh.pieces[piece].point(v - mesh.first_vertex[piece]), sum);
        }
        batch->run(sum);
        hanging += sum.hanging;
        covered += sum.covered;
      });
  return {hanging, covered};
}

} // namespace insitu::commit

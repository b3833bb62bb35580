#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "accel/tree/tree.h"
#include "cells/kernels/gather.h"
#include "core/parallel.h"
#include "mesh/box.h"
#include "query/sampler.h"

namespace insitu::render {

/// Up to 64 cells of one shape: their vertices by columns, and the boxes of these.
class CellColumns {
public:
  static constexpr int size = cells::CellBlock::size;

  mesh::Shape shape() const { return shape_; }
  /// By flat ids.
  std::span<const std::int64_t> cells() const { return {flat_, std::size_t(count_)}; }
  mesh::Box box(int k) const {
    return {{low_[0][k], low_[1][k], low_[2][k]}, {high_[0][k], high_[1][k], high_[2][k]}};
  }

private:
  friend class OwningCells;

  void find_boxes() {
    const int vertices = mesh::vertex_count(shape_);
    for (int a = 0; a < 3; ++a) {
      std::copy_n(block_.vertex[0][a], count_, low_[a]);
      std::copy_n(block_.vertex[0][a], count_, high_[a]);
      for (int v = 1; v < vertices; ++v)
        for (int k = 0; k < count_; ++k) {
          const double x = block_.vertex[v][a][k];
          low_[a][k] = x < low_[a][k] ? x : low_[a][k];
          high_[a][k] = x > high_[a][k] ? x : high_[a][k];
        }
    }
  }

  mesh::Shape shape_ = mesh::Shape::none;
  int count_ = 0;
  std::int64_t flat_[size];
  cells::CellBlock block_;
  alignas(64) double low_[3][size], high_[3][size];
};

/// The owning cells of a mesh, some at a time.
class OwningCells {
public:
  explicit OwningCells(const query::Sampler& sampler)
      : tree_(sampler.tree()), mesh_(sampler.mesh()), gather_(sampler.mesh(), 1.0) {}

  /// visit(columns), from any thread, of all owning cells, but those of runs where
  /// whole(number of the run), asked first, is true.
  template <class Whole, class Visit>
  void for_each(const core::Threads& threads, Whole&& whole, Visit&& visit) const {
    // In the tree's order, in which threads are far apart.
    threads.parallel_for(tree_.cell_count(), 1024, [&](std::int64_t begin, std::int64_t end) {
      thread_local const auto scratch = std::make_unique<Scratch>();
      for (Waiting& cells : scratch->waiting)
        cells.count = 0;
      const auto add = [&](int shape, std::int64_t flat) {
        Waiting& cells = scratch->waiting[std::size_t(shape)];
        cells.flat[cells.count++] = flat;
        if (cells.count == most_waiting)
          hand_over(shape, cells, scratch->columns, visit);
      };
      for (std::int64_t at = begin; at < end; ++at) {
        const std::int64_t flat = tree_.cells()[at];
        const std::int32_t p = mesh_.piece_of(flat);
        const mesh::PieceView& piece = mesh_.pieces[p];
        if (!piece.in_runs()) {
          add(int(gather_.shape(flat)), flat);
          continue;
        }
        if (whole(flat / piece.cells_an_item())) // of the first piece
          continue;
        for (std::int64_t k = 0; k < piece.cells_an_item(); ++k)
          if (piece.exists(flat - mesh_.first_cell[p] + k))
            add(of_runs, flat + k);
      }
      for (int shape = 0; shape < kinds; ++shape)
        while (scratch->waiting[std::size_t(shape)].count > 0)
          hand_over(shape, scratch->waiting[std::size_t(shape)], scratch->columns, visit);
    });
  }

private:
  static constexpr int of_runs = 0;                          ///< where Shape::none would be
  static constexpr int most_waiting = 2 * CellColumns::size; ///< the second half is asked for early
  static constexpr int kinds = int(mesh::Shape::pyramid) + 1;
  struct Waiting {
    int count = 0;
    std::int64_t flat[most_waiting];
  };
  struct Scratch {
    std::array<Waiting, kinds> waiting;
    CellColumns columns;
  };

  template <class Visit>
  void hand_over(int shape, Waiting& cells, CellColumns& to, Visit&& visit) const {
    const int n = std::min(cells.count, CellColumns::size), more = cells.count - n;
    to.count_ = n;
    std::copy_n(cells.flat, n, to.flat_);
    if (shape == of_runs) {
      to.shape_ = mesh::Shape::voxel;
      mesh::CellVertices cell;
      for (int k = 0; k < n; ++k) {
        mesh::gather(mesh_, cells.flat[k], cell);
        to.block_.set(cell.count, k, cell.x);
      }
    } else {
      to.shape_ = mesh::Shape(shape);
      gather_.fill(cells.flat, n, more, to.block_);
    }
    std::copy_n(cells.flat + n, more, cells.flat);
    cells.count = more;
    to.find_boxes();
    visit(std::as_const(to));
  }

  const accel::Tree& tree_;
  const mesh::MeshView& mesh_;
  cells::CellGather gather_;
};

} // namespace insitu::render

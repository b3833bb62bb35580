#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <vector>

#include "accel/tree/cell_boxes.h"
#include "core/parallel.h"

namespace insitu::accel {

/// Refuses cells whose boxes no float holds: the lowest of those met, so that the message does not
/// depend on threads.
class RefusedCells {
public:
  /// cell: the lowest of some cells' that were refused, or -1.
  void note(std::int64_t cell) {
    std::int64_t now = first_.load();
    while (cell >= 0 && cell < now && !first_.compare_exchange_weak(now, cell)) {
    }
  }
  /// Throws INSITU_ERROR_MESH if there was one.
  void check(const mesh::MeshView& mesh) const;

private:
  std::atomic<std::int64_t> first_{std::numeric_limits<std::int64_t>::max()};
};

/// What a tree holds: the cells of all pieces that own points, gridlets as wholes that go by their
/// first cells; counted, with the origin of a frame in their midst, so
/// that floats resolve the mesh and not its distance from zero.
class Owners {
public:
  Owners(const mesh::MeshView& mesh, const core::Threads& threads);

  std::int64_t count() const { return start_.back(); }
  const math::Vec3d& origin() const { return origin_; }

  static constexpr std::int64_t grain = 4096; ///< flat ids a chunk
  std::int64_t chunks() const { return std::int64_t(start_.size()) - 1; }

  /// In parallel, over all of them: put(chunk, rank, ids, boxes, n) for n of them, of flat ids
  /// `ids`, the first of them the rank-th; a chunk's come in order. The boxes are also left in
  /// `by_flat_id`, unless it is null. Throws if a box is refused.
  template <class Put>
  void for_boxes(const core::Threads& threads, Box* by_flat_id, Put&& put) const {
    const CellBoxes compute(*mesh_, origin_);
    RefusedCells refused;
    threads.parallel_for(mesh_->cell_count(), grain, [&](std::int64_t begin, std::int64_t end) {
      constexpr std::uint32_t few = 128;
      std::uint32_t ids[few];
      Box local[few];
      const std::int64_t chunk = begin / grain;
      std::int64_t rank = start_[std::size_t(chunk)];
      for (std::int64_t flat = begin; flat < end;) {
        std::uint32_t n = 0;
        while (flat < end && n < few) {
          ids[n] = std::uint32_t(flat);
          n += !selects_ || owns(flat);
          flat = selects_ ? next(flat) : flat + 1;
        }
        if (n == 0)
          break;
        const bool in_place = by_flat_id && ids[n - 1] - ids[0] == n - 1;
        Box* boxes = in_place ? by_flat_id + ids[0] : local;
        refused.note(compute.compute(ids, n, 0, boxes));
        if (by_flat_id && !in_place)
          for (std::uint32_t i = 0; i < n; ++i)
            by_flat_id[ids[i]] = local[i];
        put(chunk, rank, ids, boxes, n);
        rank += n;
      }
    });
    refused.check(*mesh_);
  }

private:
  bool owns(std::int64_t flat) const {
    const std::int32_t p = mesh_->piece_of(flat);
    const mesh::PieceView& piece = mesh_->pieces[p];
    const std::int64_t cell = flat - mesh_->first_cell[p], most = piece.cells_an_item();
    return most > 1 ? cell % most == 0 : piece.exists(cell);
  }
  /// The next flat id that may stand for something.
  std::int64_t next(std::int64_t flat) const {
    const std::int32_t p = mesh_->piece_of(flat);
    const std::int64_t most = mesh_->pieces[p].cells_an_item();
    return flat + most - (flat - mesh_->first_cell[p]) % most;
  }

  const mesh::MeshView* mesh_;
  bool selects_ = false;            ///< not every flat id stands for something
  std::vector<std::int64_t> start_; ///< ranks at the chunks' beginnings
  math::Vec3d origin_;
};

} // namespace insitu::accel

#include "commit/standins/leaves_copy.h"

#include <algorithm>
#include <atomic>
#include <utility>

namespace insitu::commit {

LeavesCopy::LeavesCopy(const amr::LeafMap& map, std::vector<std::int64_t> first_cell,
                       core::Memory& memory, const core::Threads& threads)
    : depths_(memory, INSITU_MEMORY_EARLIER), corners_(memory, INSITU_MEMORY_EARLIER),
      covered_(memory, INSITU_MEMORY_EARLIER), first_cell_(std::move(first_cell)) {
  read(map, threads);
  set_views(map.lattice());
}

/// A cell that no brick has is covered by finer ones.
void LeavesCopy::read(const amr::LeafMap& map, const core::Threads& threads) {
  const auto cells = std::size_t(first_cell_.back());
  depths_.resize_discard(cells);
  corners_.resize_discard(3 * cells);
  covered_.resize_discard((cells + 63) / 64);
  std::fill(depths_.begin(), depths_.end(), std::int8_t(0));
  std::fill(corners_.begin(), corners_.end(), 0);
  std::fill(covered_.begin(), covered_.end(), ~std::uint64_t(0));
  const amr::BrickStore& store = map.store();
  threads.parallel_for(store.brick_count(), 64, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t b = begin; b < end; ++b) {
      const std::uint32_t* const entries = store.entries(b);
      const amr::BrickKey& key = store.key(b);
      const int depth = store.depth_of(b);
      for (int e = 0; e < amr::BrickStore::brick_entries; ++e) {
        if (!amr::BrickStore::is_leaf(entries[e]))
          continue;
        const std::size_t cell = entries[e];
        depths_[cell] = std::int8_t(depth);
        corners_[3 * cell] = 8 * key.x + (e & 7);
        corners_[3 * cell + 1] = 8 * key.y + (e >> 3 & 7);
        corners_[3 * cell + 2] = 8 * key.z + (e >> 6);
        std::atomic_ref(covered_[cell >> 6])
            .fetch_and(~(std::uint64_t(1) << (cell & 63)), std::memory_order_relaxed);
      }
    }
  });
}

void LeavesCopy::set_views(const mesh::Lattice& lattice) {
  const std::size_t count = first_cell_.size() - 1;
  amr_pieces_.resize(count);
  amr_.lattice = lattice;
  amr_.level_count = mesh::AmrView::most_levels;
  for (int d = 0; d < mesh::AmrView::most_levels; ++d)
    amr_.depth_of[d] = std::int8_t(d);
  amr_.pieces = amr_pieces_.data();
  amr_.first_cell = first_cell_.data();
  amr_.piece_count = std::int32_t(count);
  for (std::size_t p = 0; p < count; ++p) {
    mesh::AmrPieceView& piece = amr_pieces_[p];
    const auto first = std::size_t(first_cell_[p]);
    piece.is_patch = false;
    piece.cell_count = first_cell_[p + 1] - first_cell_[p];
    piece.levels = reinterpret_cast<const std::byte*>(depths_.data() + first);
    piece.levels_stride = piece.level_bytes = 1;
    for (std::size_t a = 0; a < 3; ++a)
      piece.corner[a] = reinterpret_cast<const std::byte*>(corners_.data() + 3 * first + a);
    piece.corner_stride = 3 * sizeof(std::int32_t);
    leaves_.push_back({&amr_, std::int32_t(p), covered_.data()});
  }
  first_vertex_.assign(1, 0);
  for (std::size_t p = 0; p < count; ++p) {
    mesh::PieceView& view = pieces_.emplace_back();
    view.layout = mesh::CellLayout::leaves;
    view.uniform_shape = mesh::Shape::voxel;
    view.cell_count = amr_pieces_[p].cell_count;
    view.vertex_count = 8 * view.cell_count;
    view.leaves = &leaves_[p];
    first_vertex_.push_back(first_vertex_.back() + view.vertex_count);
  }
  view_.pieces = pieces_.data();
  view_.first_cell = first_cell_.data();
  view_.first_vertex = first_vertex_.data();
  view_.piece_count = std::int32_t(count);
  view_.set_plane(lattice);
}

} // namespace insitu::commit

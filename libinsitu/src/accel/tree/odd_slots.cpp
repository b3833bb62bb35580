#include "accel/tree/odd_slots.h"

#include <mutex>

namespace insitu::accel {

using math::Vec3d;

OddSlots::OddSlots(const mesh::MeshView& mesh, std::span<const std::int64_t> ids,
                   std::span<const std::uint32_t> cells, const core::Threads& threads) {
  std::uint64_t known = 0;
  for (const std::int64_t id : ids) {
    known |= std::uint64_t(1) << (id & 63);
    mesh::CellVertices cell;
    mesh::gather(mesh, id, cell);
    boxes_.push_back(mesh::box_of(cell));
    if (boxes_.size() == 1)
      all_ = boxes_[0];
    all_.extend(boxes_.back());
  }
  if (ids.empty())
    return;
  std::mutex mutex;
  threads.parallel_for(
      std::int64_t(cells.size()), 1 << 16, [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t slot = begin; slot < end; ++slot) {
          const std::int64_t id = cells[std::size_t(slot)];
          if (!(known >> (id & 63) & 1) || !std::binary_search(ids.begin(), ids.end(), id))
            continue;
          const std::lock_guard lock(mutex);
          slots_.push_back(std::uint32_t(slot));
        }
      });
  std::sort(slots_.begin(), slots_.end());
  for (const std::uint32_t slot : slots_)
    filter_ |= std::uint64_t(1) << (slot & 63);
}

bool OddSlots::may_hold(const Vec3d& p) const {
  return !boxes_.empty() && all_.holds(p) &&
         std::any_of(boxes_.begin(), boxes_.end(),
                     [&](const mesh::Box& box) { return box.holds(p); });
}

} // namespace insitu::accel

#include <algorithm>
#include <atomic>

#include "accel/tree/node.h"
#include "render/volume/macrocells.h"

namespace insitu::render {

Majorants::Majorants(const Macrocells& cells, const TransferFunction& function,
                     const core::Threads& threads, core::Memory& memory)
    : opacity_(memory, INSITU_MEMORY_RANGES) {
  opacity_.resize_discard(std::size_t(cells.grid().count()));
  refresh(cells, function, threads);
}

Majorants::Majorants(const Majorants& from, core::Memory& memory,
                     core::FunctionRef<bool(int i, int j, int k)> is_shown)
    : grid_(from.grid_), opacity_(memory, INSITU_MEMORY_RANGES), empty_share_(from.empty_share_) {
  opacity_.resize_discard(from.opacity_.size());
  for (int k = 0; k < grid_.counts[2]; ++k)
    for (int j = 0; j < grid_.counts[1]; ++j)
      for (int i = 0; i < grid_.counts[0]; ++i) {
        const auto m = std::size_t(grid_.index(i, j, k));
        opacity_[m] = from.opacity_[m] > 0 || !is_shown(i, j, k) ? from.opacity_[m] : 1.0f;
      }
}

void Majorants::refresh(const Macrocells& cells, const TransferFunction& function,
                        const core::Threads& threads) {
  grid_ = cells.grid();
  std::atomic<std::int64_t> empty{0};
  threads.parallel_for(grid_.count(), 1 << 12, [&](std::int64_t begin, std::int64_t end) {
    std::int64_t without = 0;
    for (std::int64_t i = begin; i < end; ++i) {
      const Macrocells::Range& range = cells.range(i);
      double most = range.lower <= range.upper ? function.max_opacity(range.lower, range.upper) : 0;
      if (cells.has_nan(i))
        most = std::max(most, function.nan_opacity());
      const bool none = most < TransferFunction::invisible;
      opacity_[std::size_t(i)] = none ? 0.0f : std::min(1.0f, accel::round_up(most));
      without += none;
    }
    empty += without;
  });
  empty_share_ = double(empty) / double(grid_.count());
}

} // namespace insitu::render

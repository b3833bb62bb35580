#include "amr/leaves/brick_store.h"

#include <algorithm>
#include <bit>

namespace insitu::amr {

void normalize(std::vector<BrickKey>& keys) {
  std::sort(keys.begin(), keys.end());
  keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
}

BrickTable::BrickTable(core::Memory& memory)
    : dense_(memory, INSITU_MEMORY_AMR), slots_(memory, INSITU_MEMORY_AMR) {}

void BrickTable::build(const std::vector<BrickKey>& keys, std::uint32_t first) {
  size_[0] = size_[1] = size_[2] = 0;
  dense_.resize_discard(0);
  slots_.resize_discard(0);
  if (keys.empty())
    return;
  BrickKey upper = lower_ = keys.front();
  for (const BrickKey& k : keys) {
    lower_ = {std::min(lower_.x, k.x), std::min(lower_.y, k.y), std::min(lower_.z, k.z)};
    upper = {std::max(upper.x, k.x), std::max(upper.y, k.y), std::max(upper.z, k.z)};
  }
  const double range = (double(upper.x) - lower_.x + 1) * (double(upper.y) - lower_.y + 1) *
                       (double(upper.z) - lower_.z + 1);
  if (range <= 4096 + 16 * double(keys.size())) {
    size_[0] = std::uint32_t(upper.x - lower_.x + 1);
    size_[1] = std::uint32_t(upper.y - lower_.y + 1);
    size_[2] = std::uint32_t(upper.z - lower_.z + 1);
    dense_.resize_discard(std::size_t(range));
    std::fill(dense_.begin(), dense_.end(), none);
    for (std::size_t b = 0; b < keys.size(); ++b) {
      const std::size_t x = std::size_t(keys[b].x - lower_.x),
                        y = std::size_t(keys[b].y - lower_.y),
                        z = std::size_t(keys[b].z - lower_.z);
      dense_[x + size_[0] * (y + size_[1] * z)] = first + std::uint32_t(b);
    }
    return;
  }
  slots_.resize_discard(std::bit_ceil(2 * keys.size()));
  mask_ = slots_.size() - 1;
  std::fill(slots_.begin(), slots_.end(), Slot{{0, 0, 0}, none});
  for (std::size_t b = 0; b < keys.size(); ++b) {
    std::size_t s = hash(keys[b]) & mask_;
    while (slots_[s].brick != none)
      s = (s + 1) & mask_;
    slots_[s] = {keys[b], first + std::uint32_t(b)};
  }
}

BrickStore::BrickStore(core::Memory& memory)
    : keys_(memory, INSITU_MEMORY_AMR), entries_(memory, INSITU_MEMORY_AMR) {
  for (int d = 0; d <= mesh::Lattice::most_depth; ++d)
    tables_.emplace_back(memory);
}

void BrickStore::create(const BrickKeys& keys, const core::Threads& threads) {
  depth_count_ = 0;
  std::int64_t count = 0;
  for (std::size_t d = 0; d < keys.size(); ++d) {
    first_[d] = count;
    tables_[d].build(keys[d], std::uint32_t(count));
    count += std::int64_t(keys[d].size());
    if (!keys[d].empty())
      depth_count_ = int(d) + 1;
  }
  first_[keys.size()] = count;
  keys_.resize_discard(std::size_t(count));
  for (std::size_t d = 0; d < keys.size(); ++d)
    std::copy(keys[d].begin(), keys[d].end(), keys_.begin() + first_[d]);
  entries_.resize_discard(std::size_t(count) * brick_entries);
  threads.parallel_for(count, 64, [&](std::int64_t begin, std::int64_t end) {
    std::fill(entries(begin), entries(end), nothing);
  });
}

std::int64_t BrickStore::bytes() const {
  std::int64_t sum = std::int64_t(keys_.bytes() + entries_.bytes());
  for (const BrickTable& t : tables_)
    sum += t.bytes();
  return sum;
}

} // namespace insitu::amr

#include "scene/record/piece_arrays.h"

#include <algorithm>
#include <cstring>

#include "mesh/registered/dense_items.h"

namespace insitu::scene {

using mesh::ExternalArray;

std::int64_t RecordStream::items() const {
  std::int64_t sum = 0;
  for (const RecordRun& run : runs)
    sum += run.items;
  return sum;
}

const std::byte* RecordStream::items_at(std::int64_t begin, std::int64_t end,
                                        std::byte* scratch) const {
  const std::int64_t size = item_bytes();
  std::byte* to = scratch;
  std::int64_t first = 0; // of the run
  for (const RecordRun& run : runs) {
    const std::int64_t from = std::max(begin - first, std::int64_t(0)),
                       until = std::min(end - first, run.items);
    if (from < until) {
      const std::int64_t count = until - from;
      if (run.dense && count == end - begin)
        return run.dense + from * size;
      if (run.dense)
        std::memcpy(to, run.dense + from * size, std::size_t(count * size));
      else
        run.copy(from, until, to);
      to += count * size;
    }
    first += run.items;
  }
  return scratch;
}

RecordRun run_of(const std::vector<ExternalArray>& arrays) {
  return {arrays[0].layout.count, mesh::dense_items(arrays),
          [arrays](std::int64_t begin, std::int64_t end, std::byte* to) {
            mesh::copy_dense(arrays, begin, end, to);
          }};
}

} // namespace insitu::scene

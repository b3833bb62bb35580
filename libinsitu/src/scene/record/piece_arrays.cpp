#include "scene/record/piece_arrays.h"

#include <algorithm>
#include <cstring>

namespace insitu::scene {

namespace {

using mesh::ExternalArray;

template <std::size_t bytes>
void copy_component(const ExternalArray& array, int component, std::int64_t begin, std::int64_t end,
                    std::byte* to, std::size_t step) {
  for (std::int64_t i = begin; i < end; ++i, to += step)
    std::memcpy(to, array.at(i, component), bytes);
}

/// The items [begin, end) of arrays whose components follow each other in an item.
void copy_items(const std::vector<ExternalArray>& arrays, std::int64_t begin, std::int64_t end,
                std::byte* to) {
  const int size = mesh::size_of(arrays[0].type);
  const auto step = std::size_t(components_of(arrays) * size);
  for (const ExternalArray& array : arrays)
    for (int c = 0; c < array.components; ++c, to += size) {
      if (size == 8)
        copy_component<8>(array, c, begin, end, to, step);
      else if (size == 4)
        copy_component<4>(array, c, begin, end, to, step);
      else
        copy_component<1>(array, c, begin, end, to, step);
    }
}

/// Where the items lie, if it is side by side.
const std::byte* dense_items(const std::vector<ExternalArray>& arrays) {
  const ExternalArray& a = arrays[0];
  const std::int64_t size = mesh::size_of(a.type);
  const bool dense = arrays.size() == 1 && !a.indirect && a.layout.linear &&
                     a.layout.stride[0] == a.components * size &&
                     (a.components == 1 || a.component_stride == size);
  return dense ? a.data : nullptr;
}

} // namespace

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

int components_of(const std::vector<ExternalArray>& arrays) {
  return arrays.size() == 1 ? arrays[0].components : int(arrays.size());
}

RecordRun run_of(const std::vector<ExternalArray>& arrays) {
  return {arrays[0].layout.count, dense_items(arrays),
          [arrays](std::int64_t begin, std::int64_t end, std::byte* to) {
            copy_items(arrays, begin, end, to);
          }};
}

void recorded_layers(const insitu_patch& patch, std::int64_t before[3], std::int64_t after[3]) {
  for (int a = 0; a < 3; ++a) {
    before[a] = std::min(patch.ghosts_before[a], 1);
    after[a] = std::min(patch.ghosts_after[a], 1);
  }
}

RecordRun run_of_patch(const std::vector<ExternalArray>& arrays, const insitu_patch& patch) {
  std::int64_t before[3], after[3], size[3];
  recorded_layers(patch, before, after);
  for (int a = 0; a < 3; ++a)
    size[a] = patch.cells[a] + before[a] + after[a];
  if (std::equal(size, size + 3, patch.cells))
    return run_of(arrays);
  std::vector<ExternalArray> whole = arrays; // from the first ghost on
  for (ExternalArray& array : whole) {
    mesh::ItemLayout& layout = array.layout;
    for (int a = 0; a < 3; ++a)
      array.data -= before[a] * layout.stride[a];
    layout.count = size[0] * size[1] * size[2];
    layout.extent[0] = size[0];
    layout.extent[1] = size[1];
    layout.linear = false;
  }
  return run_of(whole);
}

} // namespace insitu::scene

#include "mesh/registered/dense_items.h"

#include <algorithm>
#include <cstring>

namespace insitu::mesh {

namespace {

template <std::size_t bytes>
void copy_component(const ExternalArray& array, int component, std::int64_t begin, std::int64_t end,
                    std::byte* to, std::size_t step) {
  for (std::int64_t i = begin; i < end; ++i, to += step)
    std::memcpy(to, array.at(i, component), bytes);
}

} // namespace

int components_of(const std::vector<ExternalArray>& arrays) {
  return arrays.size() == 1 ? arrays[0].components : int(arrays.size());
}

void copy_dense(const std::vector<ExternalArray>& arrays, std::int64_t begin, std::int64_t end,
                std::byte* to) {
  const int size = size_of(arrays[0].type);
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

const std::byte* dense_items(const std::vector<ExternalArray>& arrays) {
  const ExternalArray& a = arrays[0];
  const std::int64_t size = size_of(a.type);
  const bool dense = arrays.size() == 1 && !a.indirect && a.layout.linear &&
                     a.layout.stride[0] == a.components * size &&
                     (a.components == 1 || a.component_stride == size);
  return dense ? a.data : nullptr;
}

insitu_patch as_read(insitu_patch patch) {
  for (int a = 0; a < 3; ++a) {
    patch.ghosts_before[a] = std::min(patch.ghosts_before[a], 1);
    patch.ghosts_after[a] = std::min(patch.ghosts_after[a], 1);
  }
  return patch;
}

std::array<std::int64_t, 3> extent_with_ghosts(const insitu_patch& patch) {
  std::array<std::int64_t, 3> extent{};
  for (std::size_t a = 0; a < 3; ++a)
    extent[a] = patch.cells[a] + patch.ghosts_before[a] + patch.ghosts_after[a];
  return extent;
}

std::vector<ExternalArray> with_read_layers(std::vector<ExternalArray> arrays,
                                            const insitu_patch& patch) {
  const insitu_patch read = as_read(patch);
  const std::array<std::int64_t, 3> size = extent_with_ghosts(read);
  if (std::equal(size.begin(), size.end(), patch.cells))
    return arrays;
  for (ExternalArray& array : arrays) { // from the first ghost on
    ItemLayout& layout = array.layout;
    for (int a = 0; a < 3; ++a)
      array.data -= read.ghosts_before[a] * layout.stride[a];
    layout.count = size[0] * size[1] * size[2];
    layout.extent[0] = size[0];
    layout.extent[1] = size[1];
    layout.linear = false;
  }
  return arrays;
}

std::int64_t RingsBehind::count(std::int64_t face) const {
  return std::max<std::int64_t>(load_index(counts_.at(face, 0), counts_.type == INSITU_INT32), 0);
}

std::int64_t RingsBehind::id_count() const {
  std::int64_t ids = 0;
  for (std::int64_t f = 0; f < face_count(); ++f)
    ids += count(f);
  return ids;
}

void RingsBehind::copy_ids(std::int64_t begin, std::int64_t end, std::byte* to) {
  const int size = size_of(rings_.type);
  for (; begin < end; ++begin, ++within_, to += size) {
    for (; within_ == count(face_); ++face_)
      within_ = 0;
    std::memcpy(to, rings_.at(face_, 0) + within_ * size, std::size_t(size));
  }
}

void RingsBehind::copy_places(std::int64_t begin, std::int64_t end, std::int64_t base,
                              std::byte* to) {
  for (; begin < end; ++begin, to += sizeof(std::int64_t)) {
    const std::int64_t place = base + passed_;
    std::memcpy(to, &place, sizeof place);
    passed_ += begin < face_count() ? count(begin) : 0;
  }
}

} // namespace insitu::mesh

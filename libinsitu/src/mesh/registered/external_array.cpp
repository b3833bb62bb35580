#include "mesh/registered/external_array.h"

#include <algorithm>

#include "core/caller_struct.h"
#include "core/device_memory.h"

namespace insitu::mesh {

using core::Error;

int size_of(insitu_type type) {
  switch (type) {
  case INSITU_FLOAT32:
  case INSITU_INT32:
    return 4;
  case INSITU_FLOAT64:
  case INSITU_INT64:
    return 8;
  case INSITU_UINT8:
    return 1;
  }
  return 0;
}

const char* type_name(insitu_type type) {
  switch (type) {
  case INSITU_FLOAT32:
    return "float32";
  case INSITU_FLOAT64:
    return "float64";
  case INSITU_INT32:
    return "int32";
  case INSITU_INT64:
    return "int64";
  case INSITU_UINT8:
    return "uint8";
  }
  return "unknown";
}

std::int64_t ExternalArray::bytes() const {
  return (indirect_values >= 0 ? indirect_values : layout.count * components) * size_of(type);
}

ExternalArray::Range ExternalArray::range() const {
  const auto base = reinterpret_cast<std::uintptr_t>(data);
  if (layout.count == 0)
    return {base, base};
  const std::int64_t last[4] = {
      layout.linear ? layout.count - 1 : layout.extent[0] - 1,
      layout.linear ? 0 : layout.extent[1] - 1,
      layout.linear ? 0 : layout.count / (layout.extent[0] * layout.extent[1]) - 1, components - 1};
  const std::int64_t stride[4] = {layout.stride[0], layout.stride[1], layout.stride[2],
                                  component_stride};
  std::int64_t low = 0, high = indirect ? std::int64_t(sizeof(void*)) : size_of(type);
  for (int a = 0; a < (indirect ? 3 : 4); ++a)
    (stride[a] < 0 ? low : high) += last[a] * stride[a];
  return {base + std::uintptr_t(low), base + std::uintptr_t(high)};
}

namespace {

/// Throws what is wrong with an array of pointers, before its places are worked out.
void check_pointers(const insitu_array& array, const std::string& name, Pointers pointers) {
  const auto refuse = [&](const std::string& what) {
    throw Error(INSITU_ERROR_ARGUMENT, name + ": " + what);
  };
  if (array.indirect != 0 && array.indirect != 1)
    refuse("indirect " + std::to_string(array.indirect) + ", 0 or 1 expected");
  if (!array.indirect) {
    if (array.offset != 0)
      refuse("offset " + std::to_string(array.offset) +
             " is for indirect arrays; add it to data instead");
    return;
  }
  if (pointers == Pointers::refused)
    refuse("indirect; only fields, leaves and the vertices of faces may lie behind pointers");
  if (array.memory != INSITU_HOST)
    refuse("indirect, in device memory; pointers are followed on the host only");
  constexpr std::int64_t farthest = std::int64_t(1) << 61;
  if (array.offset < -farthest || array.offset > farthest)
    refuse("offset " + std::to_string(array.offset));
}

} // namespace

ExternalArray adopt(const insitu_array* array, const std::string& name, Pointers pointers) {
  constexpr std::int64_t most_items = std::int64_t(1) << 40; // times 2^16 components of 8 bytes fit
  const auto refuse = [&](const std::string& what) {
    throw Error(INSITU_ERROR_ARGUMENT, name + ": " + what);
  };
  if (!array)
    refuse("the array is null");
  core::check_argument(array, name);
  const int item = size_of(array->type);
  if (item == 0)
    refuse("unknown type " + std::to_string(int(array->type)));
  if (array->memory != INSITU_HOST && array->memory != INSITU_DEVICE)
    refuse("unknown memory " + std::to_string(int(array->memory)));
  if (array->memory == INSITU_DEVICE && !core::device_memory_supported())
    throw Error(INSITU_ERROR_UNSUPPORTED, name + ": device memory needs a build with CUDA");
  constexpr int most_components = 1 << 16;
  if (array->components < 1 || array->components > most_components)
    refuse(std::to_string(array->components) + " components, 1 to " +
           std::to_string(most_components) + " expected");
  check_pointers(*array, name, pointers);

  ExternalArray out;
  out.data = static_cast<const std::byte*>(array->data);
  out.type = array->type;
  out.components = array->components;
  out.memory = array->memory;
  out.component_stride = array->component_stride ? array->component_stride : item;
  if (array->converted)
    out.converted = array->converted;
  out.indirect = array->indirect != 0;
  out.offset = array->offset;

  ItemLayout& layout = out.layout;
  std::int64_t extent[3] = {array->count, 1, 1};
  if (array->extent[0] != 0 || array->extent[1] != 0 || array->extent[2] != 0) {
    // Extents after the last one that is not 0 were left out; a 0 before it is an empty section.
    std::int64_t product = 1;
    bool left_out = true;
    for (int a = 2; a >= 0; --a) {
      left_out = left_out && array->extent[a] == 0;
      extent[a] = left_out ? 1 : array->extent[a];
      if (extent[a] < 0 || extent[a] > most_items ||
          (extent[a] > 0 && product > most_items / extent[a]))
        refuse("extent " + std::to_string(array->extent[a]) + " along axis " + std::to_string(a));
      product *= extent[a];
    }
    if (array->count != 0 && array->count != product)
      refuse("count " + std::to_string(array->count) + " but the extents hold " +
             std::to_string(product));
    layout.count = product;
  } else {
    if (array->count < 0 || array->count > most_items)
      refuse("count " + std::to_string(array->count));
    layout.count = array->count;
  }
  if (layout.count > 0 && !array->data)
    refuse("data is null, " + std::to_string(layout.count) + " items expected");

  // Offsets are sums of four terms, each below 2^61.
  constexpr std::int64_t farthest = std::int64_t(1) << 61;
  const auto is_too_far = [](std::int64_t stride, std::int64_t n) {
    return stride < -farthest / std::max<std::int64_t>(n, 1) ||
           stride > farthest / std::max<std::int64_t>(n, 1);
  };
  if (is_too_far(out.component_stride, out.components))
    refuse("component_stride " + std::to_string(out.component_stride));
  std::int64_t next = out.indirect              ? std::int64_t(sizeof(void*))
                      : array->component_stride ? item
                                                : std::int64_t(item) * out.components;
  for (int a = 0; a < 3; ++a) {
    layout.stride[a] = array->stride[a] ? array->stride[a] : next;
    if (is_too_far(layout.stride[a], extent[a]))
      refuse("stride " + std::to_string(layout.stride[a]) + " along axis " + std::to_string(a));
    next = extent[a] * layout.stride[a];
  }
  layout.extent[0] = extent[0];
  layout.extent[1] = extent[1];
  layout.linear =
      (extent[1] == 1 || layout.stride[1] == extent[0] * layout.stride[0]) &&
      (extent[2] == 1 || (extent[1] == 1 ? layout.stride[2] == extent[0] * layout.stride[0]
                                         : layout.stride[2] == extent[1] * layout.stride[1]));
  if (out.indirect) { // not linear, so that the usual case asks nothing more
    if (!layout.linear)
      refuse("indirect: pointers must be evenly spaced");
    layout.extent[0] = layout.count;
    layout.extent[1] = 1;
    layout.linear = false;
  }
  return out;
}

void require_real(const ExternalArray& array, const std::string& name) {
  if (array.type != INSITU_FLOAT32 && array.type != INSITU_FLOAT64)
    throw Error(INSITU_ERROR_ARGUMENT,
                name + ": type " + type_name(array.type) + ", float32 or float64 expected");
}

void require_integer(const ExternalArray& array, const std::string& name) {
  if (array.type != INSITU_INT32 && array.type != INSITU_INT64)
    throw Error(INSITU_ERROR_ARGUMENT,
                name + ": type " + type_name(array.type) + ", int32 or int64 expected");
}

} // namespace insitu::mesh

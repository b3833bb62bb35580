#include "arrays.h"

#include <algorithm>
#include <cstring>

namespace insitu::blueprint {

namespace {

std::int64_t bytes_of(insitu_type type) {
  return type == INSITU_UINT8 ? 1 : type == INSITU_FLOAT32 || type == INSITU_INT32 ? 4 : 8;
}

insitu_array in_place(const Leaf& leaf, insitu_type type) {
  insitu_array a = insitu_array_of(leaf.data, type, leaf.count, 1);
  a.stride[0] = leaf.stride == leaf.bytes() ? 0 : leaf.stride;
  return a;
}

/// Of leaves that the library reads in strides: 0 would be packed items there.
bool has_stride(const Leaf& leaf) {
  return leaf.stride != 0 || leaf.count < 2;
}

template <class T, class Get>
insitu_array copied(const Leaf& leaf, insitu_type type, Copies& copies, const char* reason,
                    Get&& get) {
  T* out = copies.make<T>(leaf.count);
  for (std::int64_t i = 0; i < leaf.count; ++i)
    out[i] = static_cast<T>(get(i));
  insitu_array a = insitu_array_of(out, type, leaf.count, 1);
  a.converted = reason;
  return a;
}

/// Mixes words of 8 bytes in four chains, which do not wait for each other.
class Mixer {
public:
  explicit Mixer(std::uint64_t seed) {
    for (std::uint64_t c = 0; c < 4; ++c)
      chains_[c] = seed + (c + 1) * odd;
  }
  void bytes(const char* data, std::size_t count) {
    for (; count >= 32; data += 32, count -= 32)
      for (int c = 0; c < 4; ++c)
        mix(chains_[c], data + 8 * c, 8);
    for (int c = 0; count > 0; ++c) {
      const std::size_t n = std::min<std::size_t>(count, 8);
      mix(chains_[c], data, n);
      data += n, count -= n;
    }
  }
  void number(std::int64_t n) { bytes(reinterpret_cast<const char*>(&n), sizeof n); }
  std::uint64_t result() const {
    std::uint64_t h = 0;
    for (const std::uint64_t c : chains_)
      h = (h ^ c) * odd, h ^= h >> 29;
    return h;
  }

private:
  static constexpr std::uint64_t odd = 0x9E3779B97F4A7C15u; // 2^64 over the golden ratio
  static void mix(std::uint64_t& chain, const char* data, std::size_t n) {
    std::uint64_t word = 0;
    std::memcpy(&word, data, n);
    chain = (chain ^ word) * odd;
    chain ^= chain >> 32;
  }
  std::uint64_t chains_[4];
};

} // namespace

insitu_array reals(const Leaf& leaf, Copies& copies) {
  if (leaf.is_real() && has_stride(leaf))
    return in_place(leaf, leaf.type == Conduit::float32 ? INSITU_FLOAT32 : INSITU_FLOAT64);
  return copied<double>(leaf, INSITU_FLOAT64, copies,
                        leaf.is_real() ? "one number for all items" : "integers",
                        [&](std::int64_t i) { return leaf.real(i); });
}

insitu_array ids(const Node& node, Copies& copies) {
  const Leaf leaf = node.leaf();
  if (!leaf.is_integer())
    node.refuse(INSITU_ERROR_ARGUMENT, "holds no integers");
  // Of unsigned ids those beyond the signed ones are out of range as negative ones are.
  if (leaf.bytes() >= 4 && has_stride(leaf))
    return in_place(leaf, leaf.bytes() == 4 ? INSITU_INT32 : INSITU_INT64);
  return copied<std::int64_t>(leaf, INSITU_INT64, copies, "integers of 8 or 16 bits",
                              [&](std::int64_t i) { return leaf.integer(i); });
}

insitu_array bytes(const Node& node, Copies& copies) {
  const Leaf leaf = node.leaf();
  if (leaf.bytes() == 1 && has_stride(leaf))
    return in_place(leaf, INSITU_UINT8);
  return copied<std::uint8_t>(leaf, INSITU_UINT8, copies, "integers of other than 8 bits",
                              [&](std::int64_t i) { return leaf.integer(i); });
}

std::vector<insitu_array> joined(std::vector<insitu_array> components) {
  const insitu_array& first = components[0];
  for (std::size_t c = 1; c < components.size(); ++c) {
    const insitu_array& next = components[c];
    const auto apart = static_cast<const char*>(next.data) - static_cast<const char*>(first.data);
    if (next.type != first.type || next.count != first.count || next.stride[0] != first.stride[0] ||
        next.stride[0] == 0 || next.converted || first.converted ||
        apart != static_cast<std::ptrdiff_t>(c) * bytes_of(first.type))
      return components;
  }
  insitu_array one = first;
  one.components = static_cast<std::int32_t>(components.size());
  if (one.stride[0] == one.components * bytes_of(one.type))
    one.stride[0] = 0;
  return {one};
}

std::vector<insitu_array> components(const Node& values, Copies& copies) {
  std::vector<insitu_array> out;
  if (values.is_leaf()) {
    out.push_back(reals(values.leaf(), copies));
    return out;
  }
  for (std::int64_t c = 0; c < values.size(); ++c) {
    const Node component = values.child(c);
    out.push_back(reals(component.leaf(), copies));
    if (out[0].count != out.back().count)
      component.refuse(INSITU_ERROR_ARGUMENT, "has " + std::to_string(out.back().count) +
                                                  " values, the first component has " +
                                                  std::to_string(out[0].count));
    if (out[0].type != out.back().type) // a field has one type
      component.refuse(INSITU_ERROR_UNSUPPORTED, "has another type than the first component");
  }
  if (out.empty())
    values.refuse(INSITU_ERROR_ARGUMENT, "has no components");
  return joined(std::move(out));
}

insitu_array block_of(insitu_array array, const std::array<std::int64_t, 3>& extent,
                      const std::array<std::int64_t, 3>& offset,
                      const std::array<std::int64_t, 3>& stride) {
  const std::int64_t item =
      array.stride[0] != 0 ? array.stride[0] : bytes_of(array.type) * array.components;
  const char* data = static_cast<const char*>(array.data);
  array.count = 1;
  for (std::size_t a = 0; a < 3; ++a) {
    data += offset[a] * stride[a] * item;
    array.extent[a] = extent[a];
    array.stride[a] = stride[a] * item;
    array.count *= extent[a];
  }
  array.data = data;
  return array;
}

double value_of(const insitu_array& array, std::int64_t item, int component) {
  const std::int64_t value = bytes_of(array.type),
                     apart = array.component_stride != 0 ? array.component_stride : value,
                     step = array.stride[0] != 0 ? array.stride[0] : value * array.components;
  const char* const at = static_cast<const char*>(array.data) + item * step + component * apart;
  const auto as = [&](auto number) {
    std::memcpy(&number, at, sizeof number);
    return static_cast<double>(number);
  };
  return array.type == INSITU_UINT8     ? as(std::uint8_t{})
         : array.type == INSITU_INT32   ? as(std::int32_t{})
         : array.type == INSITU_INT64   ? as(std::int64_t{})
         : array.type == INSITU_FLOAT32 ? as(float{})
                                        : as(double{});
}

bool is_same_view(const insitu_array& a, const insitu_array& b) {
  return a.data == b.data && a.type == b.type && a.components == b.components &&
         a.count == b.count && std::equal(a.extent, a.extent + 3, b.extent) &&
         std::equal(a.stride, a.stride + 3, b.stride) && a.component_stride == b.component_stride &&
         a.memory == b.memory;
}

bool are_same_views(const std::vector<insitu_array>& a, const std::vector<insitu_array>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), is_same_view);
}

std::uint64_t fingerprint(const insitu_array& array, std::uint64_t seed) {
  Mixer mixer(seed);
  mixer.number(array.type);
  mixer.number(array.components);
  mixer.number(array.count);
  const bool block = array.extent[0] != 0;
  const std::int64_t value = bytes_of(array.type), item = value * array.components;
  const std::int64_t extent[3] = {block ? array.extent[0] : array.count,
                                  block ? array.extent[1] : 1, block ? array.extent[2] : 1};
  const std::int64_t step = array.stride[0] != 0 ? array.stride[0] : item;
  if (array.count <= 0)
    return mixer.result();
  for (std::int64_t k = 0; k < extent[2]; ++k)
    for (std::int64_t j = 0; j < extent[1]; ++j) {
      const char* row =
          static_cast<const char*>(array.data) + j * array.stride[1] + k * array.stride[2];
      if (step == item)
        mixer.bytes(row, static_cast<std::size_t>(extent[0] * item));
      else
        for (std::int64_t i = 0; i < extent[0]; ++i)
          mixer.bytes(row + i * step, static_cast<std::size_t>(item));
    }
  return mixer.result();
}

} // namespace insitu::blueprint

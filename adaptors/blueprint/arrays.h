#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "insitu/insitu.hpp"

#include "node.h"

namespace insitu::blueprint {

/// Copies of what the library cannot read in place, as long as a domain needs them.
class Copies {
public:
  template <class T>
  T* make(std::int64_t count) {
    auto memory = std::make_unique<char[]>(static_cast<std::size_t>(count) * sizeof(T) + 1);
    T* out = reinterpret_cast<T*>(memory.get());
    memory_.push_back(std::move(memory));
    return out;
  }
  /// A copy of numbers as an array of one component.
  insitu_array array(const std::vector<std::int64_t>& values) {
    auto* out = make<std::int64_t>(static_cast<std::int64_t>(values.size()));
    std::copy(values.begin(), values.end(), out);
    return insitu_array_of(out, INSITU_INT64, static_cast<std::int64_t>(values.size()), 1);
  }

private:
  std::vector<std::unique_ptr<char[]>> memory_;
};

/// A leaf of numbers as floats or doubles; integers are copied as doubles.
insitu_array reals(const Leaf& leaf, Copies& copies);
/// A leaf of integers as int32 or int64; smaller ones are copied. node: for messages.
insitu_array ids(const Node& node, Copies& copies);
/// A leaf of integers as uint8.
insitu_array bytes(const Node& node, Copies& copies);

/// Several arrays of one component as one, where the components of an item lie side by side.
std::vector<insitu_array> joined(std::vector<insitu_array> components);

/// A field's or a coordset's values: a leaf, or one leaf a component.
std::vector<insitu_array> components(const Node& values, Copies& copies);

/// The items of an array as a block of it. offset, stride: in items.
insitu_array block_of(insitu_array array, const std::array<std::int64_t, 3>& extent,
                      const std::array<std::int64_t, 3>& offset,
                      const std::array<std::int64_t, 3>& stride);

/// A component of an array's item, of any type of number.
double value_of(const insitu_array& array, std::int64_t item, int component);

/// Whether both view the same memory in the same way.
bool is_same_view(const insitu_array& a, const insitu_array& b);
bool are_same_views(const std::vector<insitu_array>& a, const std::vector<insitu_array>& b);

/// A number that hangs on the array's values and shape alone; of two arrays that differ it is the
/// same once in 2^64.
std::uint64_t fingerprint(const insitu_array& array, std::uint64_t seed = 0);

} // namespace insitu::blueprint

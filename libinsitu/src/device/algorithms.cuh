#pragma once

#include <cstdint>
#if defined(__CUDACC__)
#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_reduce.cuh>
#include <cub/device/device_scan.cuh>
#include <cub/device/device_select.cuh>
#include <thrust/iterator/counting_iterator.h>
#include <thrust/iterator/transform_iterator.h>
#else
#include <algorithm>
#include <vector>
#endif

#include "device/buffer.h"
#include "device/launch.cuh"

/// The algorithms between kernels: CUB's on a card, plain loops on the host. All are queued on a
/// stream, and pointers are the device's. scratch: grows as an algorithm needs.
namespace insitu::device {

using Scratch = Buffer<std::byte>;

/// Sorted keys and their values lie in one of two pairs of arrays.
struct SortedPairs {
  const std::uint64_t* keys;
  const std::uint32_t* values;
};

#if defined(__CUDACC__)

namespace detail {
/// Asks an algorithm of CUB for its memory and runs it.
template <class F>
void with_scratch(Scratch& scratch, const char* what, F&& call) {
  std::size_t bytes = 0;
  check(call(static_cast<void*>(nullptr), bytes), what);
  scratch.resize_discard(bytes + 1); // null would ask again
  check(call(static_cast<void*>(scratch.data()), bytes), what);
}
} // namespace detail

/// result[0] = first joined with value(0) to value(n - 1), in any order. Index is value's argument.
template <class Index, class T, class Value, class Join>
void reduce(Scratch& scratch, std::int64_t n, const Value& value, const Join& join, const T& first,
            T* result, StreamHandle stream, const char* what) {
  const auto values = thrust::make_transform_iterator(thrust::counting_iterator<Index>(0), value);
  detail::with_scratch(scratch, what, [&](void* memory, std::size_t& bytes) {
    return cub::DeviceReduce::Reduce(memory, bytes, values, result, n, join, first, stream);
  });
}

/// The numbers below n that `keeps` is true of, in order, and how many.
template <class Keeps>
void select(Scratch& scratch, std::int64_t n, const Keeps& keeps, std::uint32_t* selected,
            std::uint32_t* count, StreamHandle stream, const char* what) {
  detail::with_scratch(scratch, what, [&](void* memory, std::size_t& bytes) {
    return cub::DeviceSelect::If(memory, bytes, thrust::counting_iterator<std::uint32_t>(0),
                                 selected, count, n, keeps, stream);
  });
}

/// sums[i] = numbers[0] + ... + numbers[i].
inline void running_sums(Scratch& scratch, const std::uint32_t* numbers, std::uint32_t* sums,
                         std::int64_t n, StreamHandle stream, const char* what) {
  detail::with_scratch(scratch, what, [&](void* memory, std::size_t& bytes) {
    return cub::DeviceScan::InclusiveSum(memory, bytes, numbers, sums, n, stream);
  });
}

/// Sorts by the lower 63 bits of the keys; values of equal keys keep their order. The second arrays
/// are written to.
inline SortedPairs sort_pairs(Scratch& scratch, std::uint64_t* keys, std::uint64_t* other_keys,
                              std::uint32_t* values, std::uint32_t* other_values, std::int64_t n,
                              StreamHandle stream, const char* what) {
  cub::DoubleBuffer<std::uint64_t> k(keys, other_keys);
  cub::DoubleBuffer<std::uint32_t> v(values, other_values);
  detail::with_scratch(scratch, what, [&](void* memory, std::size_t& bytes) {
    return cub::DeviceRadixSort::SortPairs(memory, bytes, k, v, n, 0, 63, stream);
  });
  return {k.Current(), v.Current()};
}

#else

template <class Index, class T, class Value, class Join>
void reduce(Scratch&, std::int64_t n, const Value& value, const Join& join, const T& first,
            T* result, StreamHandle, const char*) {
  *result = first;
  for (std::int64_t i = 0; i < n; ++i)
    *result = join(*result, value(Index(i)));
}

template <class Keeps>
void select(Scratch&, std::int64_t n, const Keeps& keeps, std::uint32_t* selected,
            std::uint32_t* count, StreamHandle, const char*) {
  *count = 0;
  for (std::uint32_t i = 0; i < n; ++i)
    if (keeps(i))
      selected[(*count)++] = i;
}

inline void running_sums(Scratch&, const std::uint32_t* numbers, std::uint32_t* sums,
                         std::int64_t n, StreamHandle, const char*) {
  std::uint32_t sum = 0;
  for (std::int64_t i = 0; i < n; ++i)
    sums[i] = sum += numbers[i];
}

inline SortedPairs sort_pairs(Scratch&, std::uint64_t* keys, std::uint64_t* other_keys,
                              std::uint32_t* values, std::uint32_t* other_values, std::int64_t n,
                              StreamHandle, const char*) {
  std::vector<std::uint32_t> order(static_cast<std::size_t>(n));
  for (std::int64_t i = 0; i < n; ++i)
    order[std::size_t(i)] = std::uint32_t(i);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return keys[a] < keys[b]; });
  for (std::int64_t i = 0; i < n; ++i) {
    other_keys[i] = keys[order[std::size_t(i)]];
    other_values[i] = values[order[std::size_t(i)]];
  }
  return {other_keys, other_values};
}

#endif

} // namespace insitu::device

#pragma once

#include <cstdint>

#include "device/arithmetic.cuh"

/// Which cells a node holds: the binary radix tree of sorted codes (Karras 2012), opened to eight
/// children a node.
namespace insitu::accel::cuda {

/// A node to be: sorted cells [begin, end], inner node `index` of the radix tree.
struct TreeItem {
  std::uint32_t begin, end, index, first_child;
};

/// How many leading bits two codes share; equal ones are told apart by their places. -1: no code.
INSITU_HD inline int shared_bits(const std::uint64_t* codes, std::uint32_t count, std::int64_t i,
                                 std::int64_t j) {
  if (j < 0 || j >= count)
    return -1;
  const std::uint64_t difference = codes[i] ^ codes[j];
  return difference ? device::leading_zeros(difference)
                    : 64 + device::leading_zeros(std::uint32_t(i ^ j));
}

/// The last cell of the first child of inner node i.
INSITU_HD inline std::uint32_t find_split(const std::uint64_t* codes, std::uint32_t count,
                                          std::uint32_t node) {
  const std::int64_t i = node;
  const auto shared = [&](std::int64_t j) { return shared_bits(codes, count, i, j); };
  const std::int64_t d = shared(i + 1) > shared(i - 1) ? 1 : -1;
  const int least = shared(i - d);
  std::int64_t most = 2;
  while (shared(i + most * d) > least)
    most *= 2;
  std::int64_t length = 0;
  for (std::int64_t t = most / 2; t >= 1; t /= 2)
    if (shared(i + (length + t) * d) > least)
      length += t;
  const int here = shared(i + length * d);
  std::int64_t split = 0, t = length;
  do {
    t = (t + 1) / 2;
    if (shared(i + (split + t) * d) > here)
      split += t;
  } while (t > 1);
  return std::uint32_t(i + split * d + (d < 0 ? -1 : 0));
}

/// A node's children, in order: up to eight cells, or ranges, the largest opened first and none of
/// up to eight cells, which make a full node.
struct Opened {
  std::uint32_t begin[8], end[8], index[8];
  int count = 1;

  /// halve: in the middle, deep down where codes tell little.
  INSITU_HD Opened(const TreeItem& item, const std::uint32_t* splits, bool halve) {
    if (item.end - item.begin < 8) {
      count = int(item.end - item.begin) + 1;
      for (int c = 0; c < count; ++c)
        begin[c] = end[c] = item.begin + c;
      return;
    }
    begin[0] = item.begin;
    end[0] = item.end;
    index[0] = item.index;
    while (count < 8) {
      int largest = 0;
      for (int c = 1; c < count; ++c)
        if (end[c] - begin[c] > end[largest] - begin[largest])
          largest = c;
      if (end[largest] - begin[largest] < 8)
        return;
      for (int c = count; c > largest + 1; --c) {
        begin[c] = begin[c - 1];
        end[c] = end[c - 1];
        index[c] = index[c - 1];
      }
      const std::uint32_t split =
          halve ? begin[largest] + (end[largest] - begin[largest]) / 2 : splits[index[largest]];
      begin[largest + 1] = split + 1;
      end[largest + 1] = end[largest];
      index[largest + 1] = split + 1;
      end[largest] = index[largest] = split;
      ++count;
    }
  }
};

} // namespace insitu::accel::cuda

#include "output/files/checksum.h"

#include <algorithm>
#include <cstring>

namespace insitu::output {

namespace {

constexpr std::uint64_t prime = 0x100000001b3u;
constexpr std::size_t stride = 32; ///< bytes that the lanes take at once

/// FNV-1a over 64-bit words. Each step is a bijection of its state and of the word, so a change of
/// a single word always changes the sum.
void mix(std::uint64_t& lane, const char* bytes, std::size_t count) {
  std::uint64_t word = 0;
  std::memcpy(&word, bytes, count);
  lane = (lane ^ word) * prime;
  lane ^= lane >> 32;
}

} // namespace

void Checksum::add(std::string_view bytes) {
  size_ += bytes.size();
  const auto take = [&](const char* from) {
    for (int l = 0; l < 4; ++l)
      mix(lanes_[l], from + 8 * l, 8);
  };
  if (!rest_.empty()) {
    const std::size_t more = std::min(stride - rest_.size(), bytes.size());
    rest_.append(bytes.substr(0, more));
    bytes.remove_prefix(more);
    if (rest_.size() < stride)
      return;
    take(rest_.data());
    rest_.clear();
  }
  for (; bytes.size() >= stride; bytes.remove_prefix(stride))
    take(bytes.data());
  rest_.assign(bytes);
}

std::uint64_t Checksum::sum() const {
  std::uint64_t first = lanes_[0];
  for (std::size_t at = 0; at < rest_.size(); at += 8)
    mix(first, rest_.data() + at, std::min<std::size_t>(8, rest_.size() - at));
  std::uint64_t sum = (size_ ^ first) * prime;
  for (int l = 1; l < 4; ++l)
    sum = (sum ^ lanes_[l]) * prime;
  return sum;
}

} // namespace insitu::output

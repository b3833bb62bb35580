#include "accel/morton/sort.h"

#include <algorithm>
#include <cstring>
#include <utility>
#include <vector>

namespace insitu::accel::morton {

namespace {

constexpr int most_digit_bits = 11;

struct Digit {
  int shift, bits;
  std::size_t values() const { return std::size_t(1) << bits; }
  std::size_t operator()(const Coded& item) const { return (item.code >> shift) & (values() - 1); }
};

/// The passes of a stable radix sort: every chunk knows where its items of each digit go.
class Passes {
public:
  Passes(std::int64_t n, int most_bits, const core::Threads& threads) : n_(n), threads_(threads) {
    // As few chunks as keep the threads busy; the order does not depend on how many.
    constexpr std::int64_t least = 16384;
    const std::int64_t chunks = threads.count() == 1 ? 1 : 4 * threads.count();
    grain_ = std::max(least, (n + chunks - 1) / chunks);
    counts_.resize(std::size_t((n + grain_ - 1) / grain_) << most_bits);
  }

  /// before(begin, end) comes just before the items there are counted.
  template <class Before>
  void count(Digit digit, const Coded* items, Before&& before) {
    threads_.parallel_for(n_, grain_, [&](std::int64_t begin, std::int64_t end) {
      constexpr std::int64_t in_cache = 1024;
      std::uint32_t* counts = of_chunk(begin, digit);
      std::fill_n(counts, digit.values(), 0);
      for (std::int64_t i = begin; i < end;) {
        const std::int64_t stop = std::min(end, i + in_cache);
        before(i, stop);
        for (; i < stop; ++i)
          ++counts[digit(items[i])];
      }
    });
    std::uint32_t sum = 0;
    for (std::size_t d = 0; d < digit.values(); ++d)
      for (std::int64_t begin = 0; begin < n_; begin += grain_)
        sum += std::exchange(of_chunk(begin, digit)[d], sum);
  }
  /// Items of a digit are written a cache line at a time.
  void scatter(Digit digit, const Coded* from, Coded* to) {
    threads_.parallel_for(n_, grain_, [&](std::int64_t begin, std::int64_t end) {
      constexpr std::uint32_t line = 64 / sizeof(Coded);
      std::vector<Coded> lines(digit.values() * line);
      std::vector<std::uint8_t> filled(digit.values(), 0);
      std::uint32_t* next = of_chunk(begin, digit);
      for (std::int64_t i = begin; i < end; ++i) {
        const std::size_t d = digit(from[i]);
        Coded* here = &lines[d * line];
        here[filled[d]++] = from[i];
        if (filled[d] == line) {
          std::memcpy(to + next[d], here, line * sizeof(Coded));
          next[d] += line;
          filled[d] = 0;
          __builtin_prefetch(to + next[d] + line, 1);
        }
      }
      for (std::size_t d = 0; d < digit.values(); ++d)
        std::copy_n(&lines[d * line], filled[d], to + next[d]);
    });
  }

private:
  std::uint32_t* of_chunk(std::int64_t begin, Digit digit) {
    return &counts_[std::size_t(begin / grain_) * digit.values()];
  }

  std::int64_t n_, grain_;
  const core::Threads& threads_;
  std::vector<std::uint32_t> counts_;
};

} // namespace

void sort_by_code(Coded* items, Coded* scratch, std::int64_t n, int code_bits,
                  const core::Threads& threads, MakeItems make) {
  const int count = (code_bits + most_digit_bits - 1) / most_digit_bits;
  const int most_bits = (code_bits + count - 1) / count;
  Passes passes(n, most_bits, threads);
  // The last pass ends in `items`.
  Coded* from = count % 2 == 0 ? items : scratch;
  Coded* to = count % 2 == 0 ? scratch : items;
  for (int shift = 0; shift < code_bits; shift += most_bits) {
    const Digit digit{shift, std::min(most_bits, code_bits - shift)};
    passes.count(digit, from, [&](std::int64_t begin, std::int64_t end) {
      if (shift == 0)
        make(begin, end, from);
    });
    passes.scatter(digit, from, to);
    std::swap(from, to);
  }
}

} // namespace insitu::accel::morton

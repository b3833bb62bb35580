#include "accel/morton/order.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <vector>

namespace insitu::accel::morton {

namespace {

constexpr int most_axis_bits = 10;

/// Bits an axis, for a grid of about two boxes a cell at least.
int axis_bits(std::int64_t cells) {
  return std::min(most_axis_bits, (int(std::bit_width(std::uint64_t(cells))) + 3) / 3);
}

/// The bits of a coordinate, three apart.
constexpr auto spread = [] {
  std::array<std::uint32_t, 1 << most_axis_bits> table{};
  for (std::uint32_t i = 0; i < table.size(); ++i)
    for (int b = 0; b < most_axis_bits; ++b)
      table[i] |= ((i >> b) & 1u) << (3 * b);
  return table;
}();

class Grid {
public:
  Grid(const Centres& centres, int bits) {
    double most = 0.0; // cells along an axis
    for (int a = 0; a < 3; ++a)
      most = std::max(most, cells_along(centres, a));
    for (int a = 0; a < 3; ++a) {
      const double range = double(centres.upper[a]) - double(centres.lower[a]);
      const double steps = (double(1 << bits) - 0.5) * (cells_along(centres, a) / most);
      lower_[a] = centres.lower[a];
      scale_[a] = range > 0.0 ? steps / range : 0.0;
    }
  }
  std::uint32_t code(const Box& b) const {
    const auto axis = [&](int a) {
      const double at = (double(b.lower[a] + b.upper[a]) - lower_[a]) * scale_[a];
      return spread[std::size_t(std::int32_t(at)) % spread.size()] << a;
    };
    return axis(0) | axis(1) | axis(2);
  }

private:
  /// In proportion; more than zero wherever centres differ.
  static double cells_along(const Centres& centres, int a) {
    const double range = double(centres.upper[a]) - double(centres.lower[a]);
    return range > 0.0 ? std::clamp(range / centres.extent[a], 1e-30, 1e30) : 0.0;
  }
  double lower_[3], scale_[3];
};

/// A stable radix sort's pass over one digit: every chunk knows where its items of each digit go.
class Pass {
public:
  Pass(std::int64_t n, int digit_bits, const core::Threads& threads)
      : n_(n), digits_(std::size_t(1) << digit_bits), threads_(threads) {
    // As few chunks as keep the threads busy; the order does not depend on how many.
    constexpr std::int64_t least = 16384;
    const std::int64_t chunks = threads.count() == 1 ? 1 : 4 * threads.count();
    grain_ = std::max(least, (n + chunks - 1) / chunks);
    counts_.resize(std::size_t((n + grain_ - 1) / grain_) * digits_);
  }

  /// Calls item(i), which returns the i-th item, once for each, and counts.
  template <class Item>
  void count(int shift, Item&& item) {
    std::fill(counts_.begin(), counts_.end(), 0);
    threads_.parallel_for(n_, grain_, [&](std::int64_t begin, std::int64_t end) {
      std::uint32_t* counts = &counts_[std::size_t(begin / grain_) * digits_];
      for (std::int64_t i = begin; i < end; ++i)
        ++counts[(item(i).code >> shift) & (digits_ - 1)];
    });
    std::uint32_t sum = 0;
    for (std::size_t d = 0; d < digits_; ++d)
      for (std::size_t at = d; at < counts_.size(); at += digits_) {
        const std::uint32_t here = counts_[at];
        counts_[at] = sum;
        sum += here;
      }
  }
  /// Items of a digit are written a cache line at a time.
  void scatter(int shift, const CodedCell* from, CodedCell* to) {
    threads_.parallel_for(n_, grain_, [&](std::int64_t begin, std::int64_t end) {
      constexpr std::uint32_t line = 64 / sizeof(CodedCell);
      std::vector<CodedCell> lines(digits_ * line);
      std::vector<std::uint8_t> filled(digits_, 0);
      std::uint32_t* next = &counts_[std::size_t(begin / grain_) * digits_];
      for (std::int64_t i = begin; i < end; ++i) {
        const std::size_t d = (from[i].code >> shift) & (digits_ - 1);
        CodedCell* here = &lines[d * line];
        here[filled[d]++] = from[i];
        if (filled[d] == line) {
          std::memcpy(to + next[d], here, line * sizeof(CodedCell));
          next[d] += line;
          filled[d] = 0;
          __builtin_prefetch(to + next[d] + line, 1);
        }
      }
      for (std::size_t d = 0; d < digits_; ++d)
        std::copy_n(&lines[d * line], filled[d], to + next[d]);
    });
  }

private:
  std::int64_t n_, grain_;
  std::size_t digits_;
  const core::Threads& threads_;
  std::vector<std::uint32_t> counts_;
};

} // namespace

Centres::Centres(const Box* boxes, std::uint32_t n) {
  float sum[3] = {0.0f, 0.0f, 0.0f};
  for (std::uint32_t i = 0; i < n; ++i)
    for (int a = 0; a < 3; ++a) {
      const float l = boxes[i].lower[a], u = boxes[i].upper[a], twice = l + u;
      lower[a] = twice < lower[a] ? twice : lower[a];
      upper[a] = twice > upper[a] ? twice : upper[a];
      sum[a] += u - l;
    }
  for (int a = 0; a < 3; ++a)
    extent[a] = double(sum[a]);
}

void Centres::add(const Centres& c) {
  for (int a = 0; a < 3; ++a) {
    lower[a] = std::min(lower[a], c.lower[a]);
    upper[a] = std::max(upper[a], c.upper[a]);
    extent[a] += c.extent[a];
  }
}

void order(CodedCell* cells, CodedCell* scratch, std::int64_t n, const Box* boxes,
           const Centres& centres, const core::Threads& threads) {
  const int bits = axis_bits(n);
  const Grid grid(centres, bits);
  if (constexpr std::int64_t few = 512; n <= few) {
    for (std::int64_t i = 0; i < n; ++i)
      cells[i].code = grid.code(boxes[cells[i].cell]);
    std::sort(cells, cells + n, [](const CodedCell& a, const CodedCell& b) {
      return a.code != b.code ? a.code < b.code : a.cell < b.cell;
    });
    return;
  }
  // Three passes, so that the last one ends in `cells`.
  Pass pass(n, bits, threads);
  pass.count(0, [&](std::int64_t i) {
    return scratch[i] = {grid.code(boxes[cells[i].cell]), cells[i].cell};
  });
  pass.scatter(0, scratch, cells);
  pass.count(bits, [&](std::int64_t i) { return cells[i]; });
  pass.scatter(bits, cells, scratch);
  pass.count(2 * bits, [&](std::int64_t i) { return scratch[i]; });
  pass.scatter(2 * bits, scratch, cells);
}

} // namespace insitu::accel::morton

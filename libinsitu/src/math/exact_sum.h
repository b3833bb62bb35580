#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>
#include <span>

namespace insitu::math {

/// A sum of doubles without rounding, so that it does not depend on the order in which numbers and
/// parts are added. It is an integer in units of 2^-1074, in limbs of 32 bits that lie in 64, so
/// that many numbers are added before carries are passed on. Limbs of several sums add up one by
/// one to those of the sum of all. Infinities are counted beside it; NaN is not to be added.
class ExactSum {
public:
  /// 2,098 bits that doubles span, and 62 for the number of them.
  static constexpr std::size_t limb_count = 68;
  /// limbs, then how often infinity and how often minus infinity was added.
  static constexpr std::size_t word_count = limb_count + 2;

  void add(double value) {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    const auto biased = static_cast<unsigned>(bits >> 52) & 0x7ff;
    if (biased == 0x7ff) {
      ++words_[limb_count + (bits >> 63)];
      return;
    }
    // The number is mantissa * 2^(shift - 1074).
    const std::uint64_t fraction = bits & ((std::uint64_t{1} << 52) - 1);
    const std::uint64_t mantissa = biased == 0 ? fraction : fraction | std::uint64_t{1} << 52;
    const unsigned shift = biased == 0 ? 0 : biased - 1;
    const unsigned limb = shift / 32, within = shift % 32;
    const std::uint64_t low = mantissa << within; // the lower 64 bits of up to 84
    const std::uint64_t high = mantissa >> 1 >> (63 - within);
    const std::int64_t sign = (bits >> 63) != 0 ? -1 : 1;
    words_[limb] += sign * std::int64_t(low & mask);
    words_[limb + 1] += sign * std::int64_t(low >> 32);
    words_[limb + 2] += sign * std::int64_t(high);
    if (++added_ == most_added)
      carry();
  }
  void add(const ExactSum& other) {
    ExactSum parts = other;
    parts.carry();
    carry();
    for (std::size_t i = 0; i < word_count; ++i)
      words_[i] += parts.words_[i];
    carry();
  }

  /// The words, for a sum over processes: those of up to 2^30 sums add up one by one.
  std::span<std::int64_t> words() {
    carry();
    return words_;
  }

  /// The sum / count, rounded twice: the sum to the nearest double (ties to even), then the
  /// quotient. count > 0. Infinite only if infinities were added; NaN if both were.
  double mean(std::int64_t count) const {
    const std::int64_t above = words_[limb_count], below = words_[limb_count + 1];
    if (above > 0 || below > 0)
      return above > 0 && below > 0 ? std::numeric_limits<double>::quiet_NaN()
             : above > 0            ? std::numeric_limits<double>::infinity()
                                    : -std::numeric_limits<double>::infinity();
    const double sum = rounded(0);
    if (std::isfinite(sum))
      return sum / double(count);
    return std::ldexp(rounded(64) / double(count), 64); // the sum alone is beyond all doubles
  }

private:
  static constexpr std::int64_t mask = 0xffffffff;
  static constexpr std::int64_t most_added = std::int64_t{1} << 29;

  /// Leaves limbs of 32 bits each, but for the highest, which has the sign.
  void carry() {
    for (std::size_t i = 0; i + 1 < limb_count; ++i) {
      words_[i + 1] += words_[i] >> 32;
      words_[i] &= mask;
    }
    added_ = 0;
  }

  /// The sum * 2^-down, correctly rounded where that is no subnormal number.
  double rounded(int down) const {
    ExactSum sum = *this;
    sum.carry();
    auto& limbs = sum.words_;
    const bool negative = limbs[limb_count - 1] < 0;
    if (negative) {
      for (std::size_t i = 0; i < limb_count; ++i)
        limbs[i] = -limbs[i];
      sum.carry();
    }
    std::size_t top = limb_count;
    while (top > 0 && limbs[top - 1] == 0)
      --top;
    if (top == 0)
      return 0.0;
    // The 64 bits from the highest one on, and whether anything is below.
    const int length = std::bit_width(std::uint64_t(limbs[top - 1])) + int(top - 1) * 32;
    std::uint64_t leading = 0;
    bool rest = false;
    const int from = std::max(length - 64, 0);
    for (std::size_t i = 0; i < top; ++i) {
      const auto limb = std::uint64_t(limbs[i]); // the highest one may have more than 32 bits
      const int at = int(i) * 32 - from;
      if (at <= -64) {
        rest = rest || limb != 0;
      } else if (at < 0) {
        leading += limb >> -at;
        rest = rest || (limb & ((std::uint64_t{1} << -at) - 1)) != 0;
      } else {
        leading += limb << at;
      }
    }
    // To 53 bits, ties to even; of a sum that ends at 2^-1074 no bits are lost.
    const int excess = std::max(int(std::bit_width(leading)) - 53, 0);
    if (excess > 0) {
      const std::uint64_t cut = leading & ((std::uint64_t{1} << excess) - 1);
      const std::uint64_t half = std::uint64_t{1} << (excess - 1);
      leading >>= excess;
      leading += cut > half || (cut == half && (rest || (leading & 1) != 0));
    }
    const double value = std::ldexp(double(leading), from + excess - 1074 - down);
    return negative ? -value : value;
  }

  std::array<std::int64_t, word_count> words_{};
  std::int64_t added_ = 0; ///< numbers since carries were passed on
};

} // namespace insitu::math

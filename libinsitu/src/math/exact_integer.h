#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <limits>

namespace insitu::math {

/// A signed integer of up to 12,800 bits on the stack, for the last stage of the predicates.
///
/// Doubles that share a power of two are integers: with every coordinate of a predicate scaled by
/// the same 2^-e, sums and products are exact and nothing can overflow or underflow. The doubles
/// span 2^-1074 to 2^1024, so a difference of two has at most 2,099 bits, a 3x3 determinant 6,300
/// and a product of two determinants 12,600: the capacity holds for all finite input. Ordinary
/// coordinates need 1 to 4 limbs, and cost follows the limbs in use.
class ExactInteger {
public:
  ExactInteger() = default;

  /// value * 2^-exponent, where exponent <= lowest_exponent(value). value is finite.
  ExactInteger(double value, int exponent);

  ExactInteger(const ExactInteger& other) { *this = other; }
  ExactInteger& operator=(const ExactInteger& other);

  /// -1, 0 or 1.
  int sign() const { return sign_; }

  ExactInteger operator-() const;
  friend ExactInteger operator+(const ExactInteger& a, const ExactInteger& b);
  friend ExactInteger operator-(const ExactInteger& a, const ExactInteger& b) { return a + (-b); }
  friend ExactInteger operator*(const ExactInteger& a, const ExactInteger& b);

private:
  __extension__ using Wide = unsigned __int128;
  static constexpr int capacity = 200;

  static int compare_magnitudes(const ExactInteger& a, const ExactInteger& b);
  void trim();

  int size_ = 0; // limbs in use; the highest is not zero
  int sign_ = 0;
  std::array<std::uint64_t, capacity> limbs_; // least significant first; only size_ are set
};

/// The largest e with value = integer * 2^e; a large number for zero, which has them all.
inline int lowest_exponent(double value) {
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const auto fraction = bits & ((std::uint64_t{1} << 52) - 1);
  const int biased = static_cast<int>(bits >> 52) & 0x7ff;
  if (biased == 0 && fraction == 0)
    return std::numeric_limits<int>::max();
  const auto mantissa = biased == 0 ? fraction : fraction | (std::uint64_t{1} << 52);
  return (biased == 0 ? -1074 : biased - 1075) + std::countr_zero(mantissa);
}

inline ExactInteger::ExactInteger(double value, int exponent) {
  if (value == 0.0)
    return;
  const auto bits = std::bit_cast<std::uint64_t>(value);
  const int biased = static_cast<int>(bits >> 52) & 0x7ff;
  auto mantissa = bits & ((std::uint64_t{1} << 52) - 1);
  if (biased != 0)
    mantissa |= std::uint64_t{1} << 52;
  mantissa >>= std::countr_zero(mantissa);
  const int shift = lowest_exponent(value) - exponent;
  const int whole = shift / 64, part = shift % 64;
  for (int i = 0; i < whole; ++i)
    limbs_[i] = 0;
  limbs_[whole] = mantissa << part;
  limbs_[whole + 1] = part == 0 ? 0 : mantissa >> (64 - part);
  size_ = whole + 2;
  sign_ = value < 0.0 ? -1 : 1;
  trim();
}

inline ExactInteger& ExactInteger::operator=(const ExactInteger& other) {
  size_ = other.size_;
  sign_ = other.sign_;
  for (int i = 0; i < size_; ++i)
    limbs_[i] = other.limbs_[i];
  return *this;
}

inline ExactInteger ExactInteger::operator-() const {
  ExactInteger r = *this;
  r.sign_ = -r.sign_;
  return r;
}

inline int ExactInteger::compare_magnitudes(const ExactInteger& a, const ExactInteger& b) {
  if (a.size_ != b.size_)
    return a.size_ < b.size_ ? -1 : 1;
  for (int i = a.size_ - 1; i >= 0; --i) {
    if (a.limbs_[i] != b.limbs_[i])
      return a.limbs_[i] < b.limbs_[i] ? -1 : 1;
  }
  return 0;
}

inline void ExactInteger::trim() {
  while (size_ > 0 && limbs_[size_ - 1] == 0)
    --size_;
  if (size_ == 0)
    sign_ = 0;
}

inline ExactInteger operator+(const ExactInteger& a, const ExactInteger& b) {
  if (a.sign_ == 0)
    return b;
  if (b.sign_ == 0)
    return a;
  const int order = ExactInteger::compare_magnitudes(a, b);
  const ExactInteger& large = order >= 0 ? a : b;
  const ExactInteger& small = order >= 0 ? b : a;
  ExactInteger r;
  if (a.sign_ == b.sign_) {
    ExactInteger::Wide carry = 0;
    for (int i = 0; i < large.size_; ++i) {
      carry += large.limbs_[i];
      if (i < small.size_)
        carry += small.limbs_[i];
      r.limbs_[i] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    r.size_ = large.size_;
    if (carry != 0)
      r.limbs_[r.size_++] = static_cast<std::uint64_t>(carry);
  } else {
    std::uint64_t borrow = 0;
    for (int i = 0; i < large.size_; ++i) {
      const std::uint64_t subtrahend = i < small.size_ ? small.limbs_[i] : 0;
      const std::uint64_t difference = large.limbs_[i] - subtrahend;
      r.limbs_[i] = difference - borrow;
      borrow = (large.limbs_[i] < subtrahend || difference < borrow) ? 1 : 0;
    }
    r.size_ = large.size_;
  }
  r.sign_ = large.sign_;
  r.trim();
  return r;
}

inline ExactInteger operator*(const ExactInteger& a, const ExactInteger& b) {
  ExactInteger r;
  if (a.sign_ == 0 || b.sign_ == 0)
    return r;
  r.size_ = a.size_ + b.size_;
  for (int i = 0; i < r.size_; ++i)
    r.limbs_[i] = 0;
  for (int i = 0; i < a.size_; ++i) {
    ExactInteger::Wide carry = 0;
    for (int j = 0; j < b.size_; ++j) {
      carry += static_cast<ExactInteger::Wide>(a.limbs_[i]) * b.limbs_[j] + r.limbs_[i + j];
      r.limbs_[i + j] = static_cast<std::uint64_t>(carry);
      carry >>= 64;
    }
    r.limbs_[i + b.size_] = static_cast<std::uint64_t>(carry);
  }
  r.sign_ = a.sign_ * b.sign_;
  r.trim();
  return r;
}

} // namespace insitu::math

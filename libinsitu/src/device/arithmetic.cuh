#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

#include "math/hd.h"

/// What kernels take from the hardware of a card, with the same results on the host.
namespace insitu::device {

INSITU_HD inline int count_bits(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return __popc(bits);
#else
  return std::popcount(bits);
#endif
}

/// The number of the lowest bit that is set; bits is not 0.
INSITU_HD inline int lowest_bit(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return __ffs(int(bits)) - 1;
#else
  return std::countr_zero(bits);
#endif
}

INSITU_HD inline int leading_zeros(std::uint32_t bits) {
#if defined(__CUDA_ARCH__)
  return __clz(int(bits));
#else
  return std::countl_zero(bits);
#endif
}
INSITU_HD inline int leading_zeros(std::uint64_t bits) {
#if defined(__CUDA_ARCH__)
  return __clzll(std::int64_t(bits));
#else
  return std::countl_zero(bits);
#endif
}

/// Bytes of a that are at most (at least) those of b, as bytes of 255 and 0.
INSITU_HD inline std::uint32_t bytes_at_most(std::uint32_t a, std::uint32_t b) {
#if defined(__CUDA_ARCH__)
  return __vcmpleu4(a, b);
#else
  std::uint32_t mask = 0;
  for (int shift = 0; shift < 32; shift += 8)
    if (((a >> shift) & 255u) <= ((b >> shift) & 255u))
      mask |= 255u << shift;
  return mask;
#endif
}
INSITU_HD inline std::uint32_t bytes_at_least(std::uint32_t a, std::uint32_t b) {
  return bytes_at_most(b, a);
}

#if !defined(__CUDA_ARCH__)
namespace detail {
/// a - b rounded towards `sign` infinity. The nearest double of the difference tells on which side
/// of a float the difference is, unless it is that float; then the rounding error of the double
/// tells.
inline float difference_towards(float a, float b, float sign) {
  const double x = a, y = -double(b), sum = x + y, z = sum - x;
  const double error = (x - (sum - z)) + (y - z);
  const float nearest = float(sum);
  const double beyond = (sum - double(nearest)) * double(sign);
  const bool short_of = beyond > 0.0 || (beyond == 0.0 && error * double(sign) > 0.0);
  return short_of ? std::nextafter(nearest, sign * std::numeric_limits<float>::infinity())
                  : nearest;
}
} // namespace detail
#endif

/// a - b, rounded up or down.
INSITU_HD inline float difference_above(float a, float b) {
#if defined(__CUDA_ARCH__)
  return __fsub_ru(a, b);
#else
  return detail::difference_towards(a, b, 1.0f);
#endif
}
INSITU_HD inline float difference_below(float a, float b) {
#if defined(__CUDA_ARCH__)
  return __fsub_rd(a, b);
#else
  return detail::difference_towards(a, b, -1.0f);
#endif
}

/// a / b, on a card within two units in the last place.
INSITU_HD inline float quotient_about(float a, float b) {
#if defined(__CUDA_ARCH__)
  return __fdividef(a, b);
#else
  return a / b;
#endif
}

/// A float without its fraction: 0 of numbers below 0 and of NaN, the largest number of those
/// beyond it.
INSITU_HD inline std::uint32_t whole_number(float a) {
#if defined(__CUDA_ARCH__)
  return std::uint32_t(a);
#else
  return !(a > 0.0f) ? 0u : a >= 0x1p32f ? 0xffffffffu : std::uint32_t(a);
#endif
}

INSITU_HD inline double not_a_number() {
#if defined(__CUDA_ARCH__)
  return __longlong_as_double(0x7ff8000000000000ll);
#else
  return std::numeric_limits<double>::quiet_NaN();
#endif
}

/// Adds to a number that other threads add to; returns the number before. The loops of launch() on
/// the host have one thread.
INSITU_HD inline std::uint32_t add_to(std::uint32_t* number, std::uint32_t n) {
#if defined(__CUDA_ARCH__)
  return atomicAdd(number, n);
#else
  const std::uint32_t before = *number;
  *number += n;
  return before;
#endif
}
/// Lowers a number to n, unless it is lower; raises it, unless it is higher.
template <class T>
INSITU_HD inline void lower_to(T* number, T n) {
#if defined(__CUDA_ARCH__)
  atomicMin(number, n);
#else
  *number = n < *number ? n : *number;
#endif
}
template <class T>
INSITU_HD inline void raise_to(T* number, T n) {
#if defined(__CUDA_ARCH__)
  atomicMax(number, n);
#else
  *number = n > *number ? n : *number;
#endif
}

} // namespace insitu::device

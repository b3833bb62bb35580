#pragma once

#include <cfenv>

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace insitu::core {

/// Sets the default floating-point environment (round to nearest, no traps, denormals kept) and
/// restores the caller's on destruction, flags included: Fortran hosts trap invalid operations and
/// fast-math hosts flush denormals. Cheap when there is nothing to change.
class FloatEnvironment {
public:
#if defined(__x86_64__)
  FloatEnvironment() : saved_(_mm_getcsr()) {
    if (x87_control() != default_x87) {
      full_ = true;
      std::fegetenv(&environment_);
      std::fesetenv(FE_DFL_ENV);
    }
    _mm_setcsr(default_mxcsr);
  }
  ~FloatEnvironment() {
    if (full_)
      std::fesetenv(&environment_);
    _mm_setcsr(saved_);
  }

private:
  static unsigned short x87_control() {
    unsigned short word;
    __asm__ volatile("fnstcw %0" : "=m"(word));
    return word;
  }
  static constexpr unsigned default_mxcsr = 0x1f80;
  static constexpr unsigned short default_x87 = 0x037f;
  unsigned saved_;
  bool full_ = false;
  std::fenv_t environment_;
#else
  FloatEnvironment() {
    std::fegetenv(&environment_);
    std::fesetenv(FE_DFL_ENV);
  }
  ~FloatEnvironment() { std::fesetenv(&environment_); }

private:
  std::fenv_t environment_;
#endif

public:
  FloatEnvironment(const FloatEnvironment&) = delete;
  FloatEnvironment& operator=(const FloatEnvironment&) = delete;
};

} // namespace insitu::core

#pragma once

#include <string>

namespace insitu::core {

/// The SIMD target that the library's code is dispatched to: Highway's best for the machine, or the
/// one that the environment variable INSITU_SIMD_TARGET names by Highway's names (AVX2, AVX3, NEON,
/// ...; `baseline`: the least that the build needs; `best` or empty: the best). Read once, when the
/// library is loaded; Highway has one state a process, so a solver that uses it too is dispatched
/// alike.
struct SimdTarget {
  std::string name;    ///< of the one in use
  bool asked = false;  ///< for by the variable
  std::string problem; ///< why what the variable says is not in use; empty: it is
  /// Configures an Embree device alike, for rtcNewDevice; null: Embree chooses.
  const char* embree = nullptr;
};
const SimdTarget& simd_target();

/// Throws INSITU_ERROR_ARGUMENT with the problem, if there is one.
void require_simd_target();

} // namespace insitu::core

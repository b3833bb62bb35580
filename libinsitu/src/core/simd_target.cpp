#include "core/simd_target.h"

#include <cstdint>
#include <cstdlib>
#include <hwy/highway.h>

#include "core/status.h"

namespace insitu::core {

namespace {

constexpr const char* variable = "INSITU_SIMD_TARGET";

/// Of targets that are compiled, those that the machine has; better ones have lower bits.
std::int64_t available() {
  return hwy::SupportedTargets() & HWY_TARGETS;
}

std::int64_t best_of(std::int64_t targets) {
  return targets & -targets;
}

/// The widest of Embree's instruction sets that the target has.
const char* embree_for(std::int64_t target) {
#if HWY_ARCH_X86
  if (target < HWY_AVX2)
    return "isa=avx512";
  if (target == HWY_AVX2)
    return "isa=avx2";
  if (target == HWY_SSE4)
    return "isa=sse4.2";
  return "isa=sse2";
#else
  (void)target;
  return nullptr;
#endif
}

SimdTarget choose() {
  SimdTarget out;
  std::int64_t target = best_of(available());
  if (const char* text = std::getenv(variable); text && *text && std::string(text) != "best") {
    std::int64_t named = 0;
    std::string names;
    for (std::int64_t rest = available(); rest != 0; rest &= rest - 1) {
      const std::string name = hwy::TargetName(best_of(rest));
      names += name + ", ";
      const bool is_last = (rest & (rest - 1)) == 0;
      if (name == text || (is_last && std::string(text) == "baseline"))
        named = best_of(rest);
    }
    if (named) {
      target = named;
      out.asked = true;
      out.embree = embree_for(named);
      hwy::DisableTargets(~named);
    } else {
      out.problem = std::string(variable) + " is '" + text +
                    "', which this machine and build do not have; they have " + names +
                    "best and baseline";
    }
  }
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  out.name = hwy::TargetName(target);
  return out;
}

} // namespace

const SimdTarget& simd_target() {
  static const SimdTarget chosen = choose();
  return chosen;
}

void require_simd_target() {
  if (!simd_target().problem.empty())
    throw Error(INSITU_ERROR_ARGUMENT, simd_target().problem);
}

} // namespace insitu::core

/// Before anything is dispatched. A name that unit tests, which link objects from an archive, ask
/// their linkers for.
extern "C" const bool insitu_simd_target_at_load = (insitu::core::simd_target(), true);

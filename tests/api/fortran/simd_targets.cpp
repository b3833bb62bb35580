/// Which of the machine's SIMD targets the library's code is dispatched to, for Fortran tests: a
/// Highway library in the process has one state.
#include <cstring>
#include <hwy/highway.h>

namespace {

int64_t all_targets() {
  hwy::SetSupportedTargetsForTest(0);
  return hwy::SupportedTargets();
}

} // namespace

/// With the one that the library chooses by itself, which is the best of them, first.
extern "C" int simd_targets() {
  return hwy::PopCount(uint64_t(all_targets()));
}

/// name: [16], padded with blanks.
extern "C" void use_simd_target(int number, char* name) {
  int64_t rest = all_targets();
  for (int i = 0; i < number; ++i)
    rest &= rest - 1;
  const int64_t target = rest & -rest; // better targets have lower bits
  hwy::SetSupportedTargetsForTest(target);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  std::memset(name, ' ', 16);
  const char* const text = hwy::TargetName(target);
  std::memcpy(name, text, std::strlen(text) < 16 ? std::strlen(text) : 16);
}

#!/usr/bin/env bash
# Sets up, builds and runs the whole test suite on a bare Debian 12.
#   bash tests/run.sh [--no-install] [--preset release|debug|asan|tsan] [--simd TARGET] [ctest options]
# --simd: runs the tests with that SIMD target, by Highway's names (AVX2, AVX3, baseline, ...): INSITU_SIMD_TARGET.
set -euo pipefail
source "$(dirname "$0")/../cmake/setup.sh"

preset=release
no_install=0
arguments=()
while [ $# -gt 0 ]; do
  case $1 in
    --help|-h) sed -n '2,4s/^# //p' "$0"; exit 0 ;;
    --no-install) no_install=1 ;;
    --preset) preset=$2; shift ;;
    --simd) export INSITU_SIMD_TARGET=$2; shift ;;
    *) arguments+=("$1") ;;
  esac
  shift
done

say "libinsitu: set-up, build and tests"
ensure_packages "${packages[@]}" "${test_packages[@]}" "${browser_packages[@]}"
# CUDA code is compiled wherever nvcc is; what needs a card is skipped without one.
configure_and_build "$preset" -DINSITU_BUILD_TESTS=ON -DINSITU_WITH_CUDA=AUTO \
  -DCMAKE_CUDA_ARCHITECTURES=75-virtual --
say "  tests (log: build/$preset/Testing/Temporary/LastTest.log)"
cd "$project"
status=0
ctest --preset "$preset" --parallel "$(nproc)" "${arguments[@]}" || status=$?
say "written: build/$preset (programs in bin, test log in Testing/Temporary/LastTest.log)"
exit "$status"

#!/usr/bin/env bash
# Builds and runs everything that only a GPU can show: tests, memory checks, tables.
#   bash tests/gpu/run.sh [--optix SDK] [--no-install] [--programs FOLDER] [--out FOLDER]
#     --optix SDK        folder of the OptiX SDK (or $OPTIX_ROOT): the ray methods too
#     --programs FOLDER  runs programs that were built elsewhere (gpu_* tests and insitu-bench)
#     --out FOLDER       where logs and tables go [build/gpu/out]
set -uo pipefail
source "$(dirname "$0")/../../cmake/setup.sh"

no_install=0
optix=${OPTIX_ROOT:-}
programs=
out=$project/build/gpu/out
while [ $# -gt 0 ]; do
  case $1 in
    --help|-h) sed -n '2,6s/^# \?//p' "$0"; exit 0 ;;
    --no-install) no_install=1 ;;
    --optix) optix=$2; shift ;;
    --programs) programs=$(cd "$2" && pwd); shift ;;
    --out) out=$2; shift ;;
    *) say "$1: no option; see --help"; exit 2 ;;
  esac
  shift
done

if [ -z "$programs" ]; then
  say "libinsitu on a GPU: set-up, build, tests, tables"
  ensure_packages "${packages[@]}" "${test_packages[@]}" || exit
  configure_and_build gpu ${optix:+-DINSITU_OPTIX_ROOT=$optix} -- gpu_tests insitu-bench || exit
  programs=$project/build/gpu/bin
fi
mkdir -p "$out"
failed=0

card=$(nvidia-smi --query-gpu=name,driver_version --format=csv,noheader 2>/dev/null | head -1)
say "  card: ${card:-none found}; $(date -I)"

# check NAME COMMAND...: runs it with output to a log, and says how it went.
check() {
  local name=$1 start=$SECONDS status=0
  shift
  "$@" > "$out/$name.log" 2>&1 || status=$?
  if [ $status -eq 0 ]; then
    printf '  %-44s %4d s\n' "$name" $((SECONDS - start))
  else
    say "failed: $name (status $status). The end of $out/$name.log:"
    tail -n 30 "$out/$name.log"
    failed=1
  fi
}

for test in "$programs"/gpu_*_test; do
  check "$(basename "$test")" "$test"
done
if command -v compute-sanitizer > /dev/null; then
  for test in "$programs"/gpu_*_test; do
    check "memcheck_$(basename "$test")" compute-sanitizer --error-exitcode 9 "$test" \
      --gtest_brief=1 --gtest_filter='*Small*'
  done
else
  say "  no compute-sanitizer: memory is not checked"
fi
check methods "$programs/insitu-bench" methods --points 10000000 --threads 0 \
  --json "$out/methods.json"
check methods_check "$programs/insitu-bench" methods --check --points 10000000 --threads 0
cat "$out/methods.log" "$out/methods_check.log" 2>/dev/null
say "written: $out"
exit $failed

#!/usr/bin/env bash
# Builds and runs everything that only a GPU can show: tests, memory checks, tables.
#   bash tests/gpu/run.sh [--optix SDK] [--no-install] [--programs FOLDER] [--out FOLDER]
#     --optix SDK        folder of the OptiX SDK (or $OPTIX_ROOT): the ray methods too
#     --programs FOLDER  runs programs that were built elsewhere: gpu_* tests, insitu-bench, and a file
#                        `commit` that names what they were built from
#     --out FOLDER       where logs and tables go [build/gpu/out]
set -uo pipefail
source "$(dirname "$0")/../../cmake/setup.sh"

no_install=0
optix=${OPTIX_ROOT:-}
programs=
out=$project/build/gpu/out
while [ $# -gt 0 ]; do
  case $1 in
    --help|-h) sed -n '2,7s/^# \?//p' "$0"; exit 0 ;;
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
  git -C "$project" describe --always --dirty > "$programs/commit" 2>/dev/null
fi
commit=$(cat "$programs/commit" 2>/dev/null)
mkdir -p "$out"
failed=0

card=$(nvidia-smi --query-gpu=name,driver_version --format=csv,noheader 2>/dev/null | head -1)
card=${card/, /, driver }
say "  card: ${card:-none found}; $(date -I)"

# check NAME COMMAND...: runs it with output to a log, and says how it went.
check() {
  local name=$1 start=$SECONDS status=0
  shift
  "$@" > "$out/$name.log" 2>&1 || status=$?
  if [ $status -eq 0 ]; then
    printf '  %-44s %4d s\n' "$name" $((SECONDS - start))
  elif [ $status -eq 77 ]; then # main.cpp's, of tests whose backend is not here
    printf '  %-44s %s\n' "$name" "$(grep -m 1 ^skipped "$out/$name.log")"
  else
    say "failed: $name (status $status). The end of $out/$name.log:"
    tail -n 30 "$out/$name.log"
    failed=1
  fi
}

for test in "$programs"/gpu_*_test; do
  check "$(basename "$test")" "$test"
done
if [ -z "$card" ] || ! command -v compute-sanitizer > /dev/null; then
  say "  no compute-sanitizer or no card: memory is not checked"
else
  optix_too=$(compute-sanitizer --help | grep -o -m 1 -e "--check-optix " | tr -d " ")
  for test in "$programs"/gpu_*_test; do
    check "memcheck_$(basename "$test")" compute-sanitizer --error-exitcode 9 ${optix_too:+"$optix_too"} "$test"
  done
fi

# table FILE TITLE ARGUMENTS...: what insitu-bench prints, under two lines that say what ran where.
table() {
  local file=$1 title=$2
  shift 2
  {
    echo "insitu-bench $*, $(date -I)${commit:+, at commit $commit}"
    echo "$title: $(nproc) cores; ${card:-no card}"
    "$programs/insitu-bench" "$@" --json "${file%.txt}.json"
  } > "$file"
}
check methods table "$out/card.txt" "Locator methods" methods --points 10000000 --threads 0
check methods_check table "$out/card_check.txt" "Every method against exact bvh" \
  methods --check --points 10000000 --threads 0
cat "$out/card.txt" "$out/card_check.txt"
say "written: $out; $SECONDS s in all"
exit $failed

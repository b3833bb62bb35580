#!/usr/bin/env bash
# Runs a case of tests/regression/cases and compares what it writes with its baseline.
#   run_case.sh --bin DIR --work DIR CASE [argument of the miniapp ...]
#   run_case.sh --bin DIR --work DIR --update CASE
# --bin: where the miniapps and insitu-compare are; --work: a folder to run in, emptied first. Arguments
# after the case come after its own, so they override them. --update writes the baseline anew instead.
# Exit code: 0 same, 1 different (pictures of the differences are in WORK/difference), 2 could not run.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin= work= update=0
while [ $# -gt 0 ]; do
  case $1 in
    --bin) bin=$(cd "$2" && pwd); shift 2 ;;
    --work) work=$2; shift 2 ;;
    --update) update=1; shift ;;
    --help|-h) sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    -*) echo "run_case.sh: no option '$1'; see --help" >&2; exit 2 ;;
    *) break ;;
  esac
done
[ $# -gt 0 ] && [ -n "$bin" ] && [ -n "$work" ] || { echo "run_case.sh: see --help" >&2; exit 2; }
name=$1
shift
[ -f "$here/cases/$name/case.sh" ] ||
  { echo "run_case.sh: no case '$name'; there are: $(ls "$here/cases" | tr '\n' ' ')" >&2; exit 2; }
source "$here/cases/$name/case.sh"

rm -rf "$work"
mkdir -p "$work"
"$bin/$program" "${arguments[@]}" "$@" --scene "$here/cases/$name/scene.yaml" \
  --output "$work/out" > "$work/log.txt" 2>&1 ||
  { cat "$work/log.txt" >&2; echo "run_case.sh: $program failed" >&2; exit 2; }

baseline=$here/baselines/$name
if [ "$update" = 1 ]; then
  mkdir -p "$baseline"
  rm -f "$baseline"/*
  find "$work/out" -maxdepth 1 \( -name '*.csv' -o -name '*.json' -o -name '*.png' -o -name '*.exr' -o -name '*.nc' \) \
    -exec cp {} "$baseline" \;
  echo "$baseline: $(ls "$baseline" | wc -l) files, $(du -sb "$baseline" | cut -f1) bytes"
  exit 0
fi
"$bin/insitu-compare" "$baseline" "$work/out" "${tolerances[@]}" --difference "$work/difference"

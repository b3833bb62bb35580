#!/usr/bin/env bash
# Writes the baselines anew from the miniapps as they are built now, by the commands that the tests run.
#   update_baselines.sh [DIR with the miniapps (build/release/bin)] [CASE ...]
# Look at `git diff --stat` and at the images before committing: a baseline is a claim that this is right.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
case ${1:-} in --help|-h) sed -n '2,4s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;; esac
bin=${1:-$here/../../build/release/bin}
[ $# -gt 0 ] && shift
[ $# -gt 0 ] || set -- $(ls "$here/cases")
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
for name in "$@"; do
  bash "$here/run_case.sh" --bin "$bin" --work "$work/$name" --update "$name"
done

#!/usr/bin/env bash
# Puts tables of `insitu-bench methods`, from files, between the README's <!-- methods --> marks.
#   bash tests/gpu/readme.sh tests/gpu/measured/*
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,3s/^# //p' "$0" >&2; exit 2; }
readme=$(dirname "$0")/../../README.md
text=$(mktemp)
trap 'rm -f "$text"' EXIT
for log; do
  printf '\n<details><summary>%s</summary>\n\n```\n%s\n```\n\n</details>\n' \
    "$(sed -n 2p "$log")" "$(cat "$log")"
done > "$text"
awk -v text="$text" '
  /^<!-- methods -->$/ { print; while ((getline line < text) > 0) print line; print ""; skip = 1 }
  /^<!-- \/methods -->$/ { skip = 0 }
  !skip { print }' "$readme" > "$readme.new"
mv "$readme.new" "$readme"

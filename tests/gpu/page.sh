#!/usr/bin/env bash
# Puts tables of `insitu-bench methods`, from files, between the <!-- methods --> marks of libinsitu/doc/measured/methods.md.
#   bash tests/gpu/page.sh tests/gpu/measured/*
set -euo pipefail
[ $# -ge 1 ] || { sed -n '2,3s/^# //p' "$0" >&2; exit 2; }
page=$(dirname "$0")/../../libinsitu/doc/measured/methods.md
text=$(mktemp)
trap 'rm -f "$text"' EXIT
for log; do
  printf '\n<details><summary>%s</summary>\n\n```\n%s\n```\n\n</details>\n' \
    "$(sed -n 2p "$log")" "$(cat "$log")"
done > "$text"
awk -v text="$text" '
  /^<!-- methods -->$/ { print; while ((getline line < text) > 0) print line; print ""; skip = 1 }
  /^<!-- \/methods -->$/ { skip = 0 }
  !skip { print }' "$page" > "$page.new"
mv "$page.new" "$page"

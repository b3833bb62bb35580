#!/usr/bin/env bash
# Holds the README's five ratios to the pages that they are taken from.
set -euo pipefail
cd "$(dirname "$0")/../.."
in_pages=$(bash tests/bench/table.sh --ratios)
in_readme=$(awk '$0 == "<!-- /ratios -->" { inside = 0 } inside && NF { print } $0 == "<!-- ratios -->" { inside = 1 }' README.md)
[ "$in_pages" = "$in_readme" ] || {
  echo "README.md does not have the ratios of the pages; bash tests/bench/table.sh --ratios --write mends that:"
  diff <(echo "$in_readme") <(echo "$in_pages") || true
  exit 1
}

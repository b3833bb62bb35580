#!/usr/bin/env bash
# A run whose particles the material carries fits no tree, though its mesh moves at every commit.
#   carried.sh BIN WORK    BIN: where the miniapps are; WORK: a folder to run in
set -euo pipefail
here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
rm -rf "$2"
mkdir -p "$2"
"$1/sedov" --mesh hexahedra --cells 20 --cycles 20 --quiet --scene "$here/carried.yaml" --output "$2/out" > "$2/log.txt"
grep -q '1600 seeded = 1600 alive' "$2/log.txt" || { cat "$2/log.txt" >&2; exit 1; }
fits=$(grep -A 3 '"fits_put_off"' "$2/out/summary.json" | tr -d ' \n')
[ "$fits" = '"fits_put_off":{"count":20,"refit":0,"rebuild":0,' ] ||
  { echo "carried.sh: 20 fits put off, none done expected; $fits found" >&2; exit 1; }

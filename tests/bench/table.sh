#!/usr/bin/env bash
# Makes the README's table of measured figures: libinsitu beside VTK's fastest locator, in one run each.
#   bash tests/bench/table.sh [cells]        (1000000; about five minutes)
set -euo pipefail
cd "$(dirname "$0")/../.."
bench=build/release/bin/insitu-bench
cells=${1:-1000000}
[ -x "$bench" ] || { echo "build first: bash tests/run.sh, or cmake --build --preset release" >&2; exit 2; }
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT

# ours FILE KEY, theirs FILE KEY: the first value of a key at the top, and in the peer's object.
ours() { awk -F': ' -v k="\"$2\"" '$1 ~ k { sub(/,$/, "", $2); print $2; exit }' "$1"; }
theirs() {
  awk -F': ' -v k="\"$2\"" '/"vtkStaticCellLocator": \{$/ { inside = 1 }
    inside && $1 ~ k { sub(/,$/, "", $2); print $2; exit }' "$1"
}

echo "Measured $(date -u +%Y-%m-%d) on $(nproc) cores, $(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo); one thread;" \
  "medians of 3. Million queries a second (locate with parametric coordinates), beside vtkStaticCellLocator in the same run:"
echo
echo "| mesh, queries | libinsitu | VTK | ratio | lost, wrong (VTK) | build ms | refit ms | bytes a cell (VTK) |"
echo "|---|---|---|---|---|---|---|---|"
for run in hex:uniform hex:random hex:march tet:random wedge:random; do
  shape=${run%:*} queries=${run#*:}
  f=$out/$shape-$queries.json
  "$bench" locate --shape "$shape" --cells "$cells" --queries "$queries" --repetitions 3 --peers --json "$f" > /dev/null
  awk -v name="$shape, $queries" -v a="$(ours "$f" mqps)" -v b="$(theirs "$f" mqps)" \
    -v n="$(ours "$f" cells)" -v lost="$(ours "$f" lost)" -v wrong="$(ours "$f" wrong)" \
    -v vlost="$(theirs "$f" lost)" -v vwrong="$(theirs "$f" wrong)" \
    -v build="$(ours "$f" build_s)" -v refit="$(ours "$f" refit_s)" \
    -v bytes="$(ours "$f" bytes)" -v vbytes="$(theirs "$f" bytes)" 'BEGIN {
      printf "| %s | %.2f | %.2f | %.1f | %d, %d (%d, %d) | %.0f | %.0f | %.0f (%.0f) |\n", name, a, b, a / b,
        lost, wrong, vlost, vwrong, 1e3 * build, 1e3 * refit, bytes / n, vbytes / n }'
done
f=$out/commit.json
"$bench" commit --cells "$cells" --json "$f" > /dev/null
echo
awk -v r="$(ours "$f" refit_over_medium_rebuild)" -v v="$(ours "$f" refit_s)" -v n="$(ours "$f" cells)" 'BEGIN {
  printf "Refit over a rebuild by surface area: %.3f (%.1f M cells/s refitted).\n", r, 1e-6 * n / v }'

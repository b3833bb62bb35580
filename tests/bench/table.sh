#!/usr/bin/env bash
# Makes the tables of measured figures (libinsitu/doc/measured): libinsitu beside VTK's locators, each row one run, adaptive meshes, and
# what effects of frames cost.
#   bash tests/bench/table.sh [cells] [--measured|--scale|--amr|--amr_octrees|--amr_sizes|--effects|--accuracy|--frames|--advect|--openvkl|--sedov|--rathke|--scaling|--sections|--polyhedra|--ratios]
#     [--write]
# cells: 1000000, about twenty minutes; the large rows take eight times as many. A part alone: --measured, the tables beside
# VTK's locators; --scale, 1e4 to 3e7 cells, three minutes and 8 GiB, and libinsitu/doc/scale.svg; --amr, adaptive
# meshes, two minutes, beside Open VKL if the binary was built with it; --amr_octrees, the same of octrees alone; --amr_sizes, these by number of leaves, a minute;
# --effects, five minutes; --accuracy, what accuracy costs, a minute (small meshes; its page goes to out/accuracy);
# --frames, frames by ray marching, three minutes, beside VTK's and, by a binary that was built with it, Open VKL's;
# --advect, particles, beside VTK's in hexahedra, two minutes; --openvkl, points beside Open VKL, two minutes, by such a
# binary; --sedov, what the main job ends with, a minute; --rathke, table 1 of Rathke 2015, three minutes; --scaling, several processes, five minutes; --sections, structured blocks, a minute; --polyhedra, cells given by faces beside VTK, a minute with 200000 cells; --ratios, nothing is measured: five ratios of the pages, for the README.
# --write: puts each part into its page, between the marks of its name, <!-- scale --> and so on, instead of printing it; the
# ratios into the README.
# INSITU_BENCH: another binary. REPETITIONS: of --scaling, 3 without it, and --sections, 7.
set -euo pipefail
cd "$(dirname "$0")/../.."
bench=${INSITU_BENCH:-build/release/bin/insitu-bench}
cells=1000000 write= parts="measured scale amr amr_octrees amr_sizes frames effects advect accuracy"
for argument; do
  case $argument in
    --write|--readme) write=1 ;;
    --measured|--scale|--amr|--amr_octrees|--amr_sizes|--effects|--accuracy|--frames|--advect|--openvkl|--sedov|--rathke|--scaling|--sections|--polyhedra|--ratios) parts=${argument#--} ;;
    *[!0-9]* | '') sed -n '2,16s/^# //p' "$0" >&2; exit 2 ;;
    *) cells=$argument ;;
  esac
done
[ -x "$bench" ] || [ "$parts" = ratios ] || { echo "build first: bash tests/run.sh, or cmake --build --preset release" >&2; exit 2; }
out=$(mktemp -d)
trap 'rm -rf "$out"' EXIT
static=vtkStaticCellLocator tree=vtkCellTreeLocator
display=$(command -v xvfb-run > /dev/null && echo xvfb-run -a || true) # for VTK's frames

# ours KEY, theirs KEY: the first value of a key of the run just made, at the top and in its peer's object.
ours() { awk -F': ' -v k="\"$1\"" '$1 ~ k { sub(/,$/, "", $2); print $2; exit }' "$out/run.json"; }
theirs() { sed -nE "s/.*\"$peer\": \{.*\"$1\": ([^,}]*).*/\1/p" "$out/run.json"; }
locate() { "$bench" locate --repetitions 3 "$@" --json "$out/run.json" > /dev/null; }

# row NAME PEER OPTIONS...: a run and its row.
row() {
  local name=$1 peer=$2
  shift 2
  locate --cells "$cells" "$@" --peer "$peer"
  awk -v name="$name" -v n="$(ours cells)" -v a="$(ours mqps)" -v b="$(theirs mqps)" \
    -v ratio="$(ours "ratio_$peer")" -v with="$(ours "ratio_unsorted_$peer")" \
    -v exact="$(ours exact_over_standard)" -v lost="$(ours lost)" -v wrong="$(ours wrong)" \
    -v vlost="$(theirs lost)" -v vwrong="$(theirs wrong)" -v error="$(ours max_error)" \
    -v verror="$(theirs max_error)" -v build="$(ours build_s)" -v refit="$(ours refit_s)" \
    -v bytes="$(ours bytes)" -v vbytes="$(theirs bytes)" 'BEGIN {
      printf "| %s | %.2f | %.3g | %.1f%s | %.2f | %d, %d (%d, %d) | %.0e (%.0e) | %.0f | %.0f | %.0f (%.0f) |\n",
        name, a, b, ratio, with == "" ? "" : sprintf("; %.1f", with), exact, lost, wrong, vlost, vwrong,
        error, verror, 1e3 * build, 1e3 * refit, bytes / n, vbytes / n }'
}

measured() {
  echo "Measured $(date -u +%Y-%m-%d) on $(nproc) cores, $(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo);" \
    "one thread; medians of 3; $cells cells, jitter 0.2." \
    "Million queries a second (locate, with parametric coordinates), beside VTK in the same run:" \
    "$static, but where the row says otherwise. Ratio: of processor time, the library's own sort of" \
    "incoherent batches included; the second, where there is one: without that sort. Exact: its time over that of standard." \
    "Error: of a linear field."
  echo
  echo "| mesh, queries | libinsitu | VTK | ratio | exact | lost, wrong (VTK) | error (VTK) | build ms | refit ms | bytes a cell (VTK) |"
  echo "|---|---|---|---|---|---|---|---|---|---|"
  for shape in hex tet wedge; do
    for queries in uniform random sorted march; do
      row "$shape, $queries" $static --shape $shape --queries $queries
    done
  done
  row "hex, random, cells and vertices shuffled" $static --queries random --numbering shuffled
  # On these, VTK's bins hold so many cells that it answers few points.
  for kind in graded layers; do
    row "hex $kind, random" $static --kind $kind --queries random --peer-points 1000
    row "hex $kind, random; $tree" $tree --kind $kind --queries random --peer-points 100000
  done
  row "hex sparse, random" $static --kind sparse --queries random
  row "hex, all on faces" $static --queries faces --points $((cells / 5))
  local price_faces
  price_faces=$(ours boundary_over_random)
  row "hex times 8, uniform" $static --cells $((8 * cells)) --queries uniform
  row "hex times 8, random" $static --cells $((8 * cells)) --queries random --points "$cells"

  locate --cells "$cells" --queries random --fields 5 --points $((cells / 2))
  echo
  awk -v faces="$price_faces" -v fields="$(ours fields_over_one)" -v single="$(ours single_us)" \
    -v exact="$(ours single_exact_us)" 'BEGIN {
      printf "A batch of points on faces costs %.1f times one of random points; sampling five fields at once, ", faces
      printf "%.2f times sampling one; one random point a call, %.2f microseconds (exact: %.2f).\n", fields, single, exact }'
  "$bench" commit --cells "$cells" --json "$out/run.json" > /dev/null
  awk -v own="$(ours refit_medium_over_medium_rebuild)" -v r="$(ours refit_over_medium_rebuild)" \
    -v v="$(ours refit_s)" -v n="$(ours cells)" 'BEGIN {
      printf "Refit of a tree built by surface area over its rebuild: %.3f; of the tree in Morton order over the same: ", own
      printf "%.3f (%.1f M cells/s).\n", r, 1e-6 * n / v }'
  echo
  echo "\`insitu-bench torture\` on the small meshes of hard cases:" \
    "points lost / answered by a cell that does not hold them / by another than the lowest id that does, by method:"
  echo
  "$bench" torture > "$out/torture.txt" || true
  awk '/^ +cells +owned/ { for (i = 3; i <= NF; ++i) head = head " | " $i; columns = NF - 2 }
    /On the valid meshes/ { print "| points on valid meshes | number |" substr(head, 3) " |"
      line = "|---|---|"; for (i = 0; i < columns; ++i) line = line "---|"; print line; inside = 1; next }
    inside && NF == 0 { exit }
    inside { name = ""; for (i = 1; i <= NF - 2 * columns - 2; ++i) name = name (i > 1 ? " " : "") $i
      line = "| " name " | " $(NF - 2 * columns - 1) " |"; for (i = 0; i < columns; ++i) line = line " " $(NF - 2 * columns + 1 + 2 * i) " |"
      print line }' "$out/torture.txt"
  echo
  sed -nE 's/^  (Ours lost.*|[0-9]+ FAILED|[0-9]+ answers are not.*)$/\1/p; s/^  ([0-9]+ FAILED):$/\1/p' "$out/torture.txt"
}

openvkl() {
  echo "Measured $(date -u +%Y-%m-%d), $(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo), one thread, medians of 3," \
    "$cells cells, jitter 0.2, in one run: million queries a second, the library's own sort of random points included." \
    "Open VKL samples in float, hexahedra by its iterative option, 1024 points a call."
  echo
  echo "| mesh, queries | libinsitu | Open VKL | ratio | lost (Open VKL) | error (Open VKL) | build ms | bytes a cell |"
  echo "|---|---|---|---|---|---|---|---|"
  local shape queries peer=OpenVKL
  for shape in hex tet wedge; do
    for queries in uniform random sorted march faces edges vertices; do
      locate --cells "$cells" --shape $shape --queries $queries --peer OpenVKL \
        --points $(case $queries in faces|edges|vertices) echo $((cells / 5)) ;; *) echo "$cells" ;; esac)
      awk -v name="$shape, $queries" -v n="$(ours cells)" -v a="$(ours mqps)" -v b="$(theirs mqps)" \
        -v ratio="$(ours ratio_OpenVKL)" -v q="$(ours queries)" -v lost="$(ours lost)" -v vlost="$(theirs lost)" \
        -v error="$(ours max_error)" -v verror="$(theirs max_error)" -v build="$(ours build_s)" \
        -v vbuild="$(theirs build_s)" -v bytes="$(ours bytes)" -v vbytes="$(theirs bytes)" 'BEGIN {
          printf "| %s | %.2f | %.3g | %.1f | %d (%s) | %.0e (%s) | %.0f (%.0f) | %.0f (%.0f) |\n", name, a, b, ratio, lost,
            vlost == 0 || vlost / q < 0.0005 ? vlost : sprintf("%.1f %%", 100 * vlost / q), error,
            vlost == q ? "-" : sprintf("%.0e", verror), 1e3 * build, 1e3 * vbuild, bytes / n, vbytes / n }'
    done
  done
}

frames() {
  echo "\`insitu-bench render --peers --jitter 0.15\`, $(date -u +%Y-%m-%d) on $(nproc) cores," \
    "$(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo)."
  echo
  echo '```'
  $display "$bench" render --peers --jitter 0.15 --cells "$cells" 2> /dev/null
  echo '```'
}

advect() {
  echo "\`insitu-bench advect --peers\`, $(date -u +%Y-%m-%d) on $(nproc) cores," \
    "$(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo); then tetrahedra, whose numbers tell no neighbours, alone."
  echo
  echo '```'
  "$bench" advect --peers 2> /dev/null
  echo
  "$bench" advect --shape tet 2> /dev/null
  echo '```'
}

scale() {
  echo "\`insitu-bench scale --threads 1\`, $(date -u +%Y-%m-%d), $(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo):" \
    "a million queries a size, or batches of 100 to ten million on a million cells. Nodes and candidates are a query's."
  echo
  echo '```'
  "$bench" scale --threads 1 --repetitions 3 --svg libinsitu/doc/scale.svg 2> /dev/null
  echo '```'
  echo
  echo '![Time and work by number of cells, and time by size of the batch](../scale.svg)'
}

amr() {
  echo "\`insitu-bench amr --peers\`, $(date -u +%Y-%m-%d) on $(nproc) cores, $(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo)." \
    "Build: from the solver's arrays to ready to sample; fields: a commit of new values."
  echo
  echo '```'
  "$bench" amr --peers 2> /dev/null
  echo '```'
}

amr_octrees() {
  echo "\`insitu-bench amr\`, $(date -u +%Y-%m-%d) on $(nproc) cores, $(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo)," \
    "one thread: columns as in [adaptive meshes](amr.md)."
  echo
  echo '```'
  "$bench" amr 2> /dev/null |
    awk '/^ +build s / || /^patches, dual/ || /^the same as plain/ || /^(front|random) octree, (dual mesh|plain cells)/'
  echo '```'
}

amr_sizes() {
  echo "\`insitu-bench amr --sizes\`, $(date -u +%Y-%m-%d) on $(nproc) cores, $(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo)." \
    "Build: from the solver's arrays to ready to sample, one thread."
  echo
  echo '```'
  "$bench" amr --sizes 2> /dev/null
  echo '```'
}

effects() {
  echo "\`insitu-bench effects --cells 125000 --repetitions 3\`, $(date -u +%Y-%m-%d) on $(nproc) cores," \
    "$(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo)."
  echo
  echo '```'
  "$bench" effects --cells 125000 --repetitions 3 2> /dev/null
  echo '```'
}

rathke() {
  echo "\`insitu-bench paper rathke --table 1 --cells $cells --size 512\`, $(date -u +%Y-%m-%d) on $(nproc) cores," \
    "$(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo)."
  echo
  echo '```'
  "$bench" paper rathke --table 1 --cells "$cells" --size 512 2> /dev/null
  echo '```'
}

sections() {
  local options="--cells $cells --points $cells --repetitions ${REPETITIONS:-7}"
  echo "\`insitu-bench sections $options\`, $(date -u +%Y-%m-%d) on $(nproc) cores," \
    "$(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo), one thread; the machine's load before: $(cut -d' ' -f1 /proc/loadavg)."
  echo
  echo '```'
  "$bench" sections $options 2> /dev/null
  echo '```'
}

polyhedra() {
  echo "Measured $(date -u +%Y-%m-%d) on $(nproc) cores, $(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo);" \
    "one thread; medians of 3; about $cells cells, jitter 0.2, as many points, of which 5000 for VTK;" \
    "the machine's load before: $(cut -d' ' -f1 /proc/loadavg). Columns as in [points, beside VTK](measured.md), beside $static."
  echo
  echo "| mesh, queries | libinsitu | VTK | ratio | exact | lost, wrong (VTK, of 5000) | error (VTK) | build ms | refit ms | bytes a cell (VTK) |"
  echo "|---|---|---|---|---|---|---|---|---|---|"
  local queries
  for queries in uniform random; do
    row "hexahedra by shape, $queries" $static --queries $queries --peer-points 5000
    row "the same by faces, $queries" $static --shape hexfaces --queries $queries --peer-points 5000
    row "truncated octahedra, $queries" $static --shape poly --queries $queries --peer-points 5000
  done
}

scaling() {
  local options="--cells $cells --points 100000 --repetitions ${REPETITIONS:-3}"
  echo "\`insitu-bench scaling $options\`, $(date -u +%Y-%m-%d) on $(nproc) cores," \
    "$(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo), a thread a process; the machine's load before: $(cut -d' ' -f1 /proc/loadavg)." \
    "More processes than cores share them: seconds then say nothing, processor time and counts do."
  echo
  echo '```'
  "$bench" scaling $options 2> /dev/null
  echo '```'
}

accuracy() {
  echo "\`insitu-bench accuracy\`, $(date -u +%Y-%m-%d) on $(nproc) cores, small meshes: each choice against a reference that is" \
    "exact or far better converged. Its page, \`report.html\`, has the plots; \`--full\` takes large meshes and some twenty minutes."
  echo
  echo '```'
  $display "$bench" accuracy --out out/accuracy 2> /dev/null | fold -s -w 128 | sed 's/ *$//'
  echo '```'
}

# ratios: five of the figures that stand in the pages, with their dates, for the README. Fails where a page lacks one, as after
# a run without its peer.
ratios() {
  local pages=libinsitu/doc/measured
  # date_of PAGE: of its table.
  date_of() { grep -m 1 -oE '20[0-9]{2}-[0-9]{2}-[0-9]{2} on ' "$pages/$1.md" | cut -d' ' -f1; }
  # cell PAGE ROW COLUMN: of a Markdown table.
  cell() { awk -F'|' -v row=" $2 " -v c="$3" '$2 == row { split($(c + 1), v, ";"); gsub(/ /, "", v[1]); print v[1]; exit }' "$pages/$1.md"; }
  # faster PAGE AFTER: of the first line "N times as fast" behind a line that begins so.
  faster() { awk -v after="$2" 'index($0, after) == 1 { seen = 1 } seen && match($0, /[0-9.]+ times as fast/) { print substr($0, RSTART, RLENGTH); exit }' "$pages/$1.md" | cut -d' ' -f1; }
  # raster: samples in turns, of the line that the adaptive page has where Open VKL was there.
  raster() { sed -nE "s/^dual mesh of patches over Open VKL's octant, in turns: .* ([0-9.]+) on the raster\$/\1/p" "$pages/amr.md"; }
  # line PAGE WHAT FIGURE UNIT: a row of the README's table.
  line() {
    local date
    date=$(date_of "$1") || date=
    [[ "$3" =~ ^[0-9]+(\.[0-9]+)?$ && -n "$date" ]] ||
      { echo "$pages/$1.md has no figure or no date for: $2 (figure '$3', date '$date')" >&2; return 1; }
    echo "| $2 | $3 $4 | [$date]($pages/$1.md) |"
  }
  echo "| what | ratio | measured |"
  echo "|---|---|---|"
  line measured "random points located in hexahedra, beside \`vtkStaticCellLocator\`" "$(cell measured 'hex, random' 4)" "times as fast" &&
    line measured "the same in \`exact\`, beside \`standard\`" "$(cell measured 'hex, random' 5)" "of the time" &&
    line amr "samples of an adaptive mesh's dual on a raster, beside Open VKL's \`octant\`" "$(raster)" "times as many" &&
    line advect "particles by RK4 at an error no larger, beside \`vtkStreamTracer\`" "$(faster advect 'vtkStreamTracer RK4 ')" "times as fast" &&
    line frames "a volume's frame, beside VTK's ray cast mapper" "$(faster frames vtkUnstructuredGridVolumeRayCastMapper)" "times as fast"
}

# sedov: what the main job ends with.
sedov() {
  echo "\`examples/sedov\` with its scene and \`--material 1000\`, $(date -u +%Y-%m-%d) on $(nproc) cores," \
    "$(awk -F': ' '/model name/ {print $2; exit}' /proc/cpuinfo)."
  echo
  echo '```'
  "$(dirname "$bench")/sedov" --scene examples/sedov/scene.yaml --output out/sedov --material 1000
  echo '```'
}

# fill PART: puts what that function prints between the marks of that name in its page.
fill() {
  local page=libinsitu/doc/measured/$1.md
  [ "$1" = ratios ] && page=README.md
  grep -q "^<!-- $1 -->\$" "$page" && grep -q "^<!-- /$1 -->\$" "$page" ||
    { echo "$page has no lines <!-- $1 --> and <!-- /$1 -->" >&2; exit 2; }
  "$1" > "$out/$1.md"
  awk -v file="$out/$1.md" -v begin="<!-- $1 -->" -v end="<!-- /$1 -->" '$0 == end { skip = 0 } !skip
    $0 == begin { print ""; while ((getline line < file) > 0) print line; print ""; skip = 1 }' "$page" > "$out/page.md"
  cp "$out/page.md" "$page"
  echo "$page: $1 written"
}

for part in $parts; do
  if [ -n "$write" ]; then fill "$part"; else "$part"; echo; fi
done

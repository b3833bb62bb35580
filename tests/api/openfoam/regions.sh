#!/bin/sh
# Air over a hot plate by chtMultiRegionFoam, both regions in one session, on one and two processes in strict mode: probes have what
# OpenFOAM's own probes read in each region, cells have the numbers of the whole meshes, and a frame shows both. Where
# meshes move, each is told of its own. Regions that are wrong are named, and the solver goes on.
#   regions.sh CASE FOLDER PROGRAM   the program is of two_meshes.cpp   77: OpenFOAM's programs are not there
set -e
for program in chtMultiRegionFoam blockMesh decomposePar foamDictionary mpirun; do
  command -v "$program" > /dev/null || { echo "skipped: no $program"; exit 77; }
done
# Debian's OpenFOAM is not told where its own files are.
if [ -z "$WM_PROJECT_DIR" ] && [ -d /usr/share/openfoam ]; then
  export WM_PROJECT_DIR=/usr/share/openfoam
fi

# make FOLDER: the case with its meshes.
make() {
  mkdir -p "$1"
  cp -r "$case/constant" "$case/system" "$case/scene.yaml" "$1"
  cp -r "$case/0.orig" "$1/0"
  for region in air plate; do
    blockMesh -case "$1" -region "$region" > "$1/log.blockMesh.$region" 2>&1 || { cat "$1/log.blockMesh.$region"; exit 1; }
  done
}

# compare REGION TABLE FIELD COLUMN: the column of the session's table and OpenFOAM's own probes, at both points in each cycle. Both
# print 12 digits or more; 1e-9 of the value is room for the last ones.
compare() {
  awk -v column="$4" -v file="$3" '
    FNR == NR { gsub(/[()]/, " "); if ($1 !~ /^#/) { n++; for (i = 2; i <= NF; ++i) of[n, i - 1] = $i; width = (NF - 1) / 2 } next }
    FNR == 1 { split($0, names, ","); for (i in names) if (names[i] == column) at = i; next }
    { split($0, v, ","); row = int((FNR - 2) / 2) + 1; which = (FNR - 2) % 2
      offset = column ~ /_y$/ ? 2 : column ~ /_z$/ ? 3 : 1
      want = of[row, which * width + offset]; d = v[at] - want; if (d < 0) d = -d
      if (want == "" || v[at] == "" || d > 1e-9 * (want < 0 ? -want : want) + 1e-12) { print file " " column " row " FNR ": " v[at] " is not " want; bad = 1 }
      rows++ }
    END { if (bad || !at || rows != 2 * n || n != 20) { print file " " column ": " rows " rows, " n " of OpenFOAM"; exit 1 } }
  ' "$1" "$2"
}

case=$1
rm -rf "$2"
mkdir -p "$2"
folder=$(realpath "$2")
for processes in 1 2; do
  run=$folder/$processes
  make "$run"
  if [ "$processes" -gt 1 ]; then
    decomposePar -case "$run" -allRegions > "$run/log.decomposePar" 2>&1 || { cat "$run/log.decomposePar"; exit 1; }
    (cd "$run" && mpirun -n "$processes" chtMultiRegionFoam -parallel > log 2>&1) || { tail "$run/log"; exit 1; }
  else
    (cd "$run" && chtMultiRegionFoam > log 2>&1) || { tail "$run/log"; exit 1; }
  fi
  if grep "Warning : function object insitu" "$run/log" | grep -v MPI_THREAD_SINGLE; then
    exit 1
  fi
  own=$run/postProcessing
  compare "$own/air/air/0/T" "$own/insitu/in_air.csv" in_air T
  for axis in x y z; do
    compare "$own/air/air/0/U" "$own/insitu/in_air.csv" in_air "U_$axis"
  done
  compare "$own/plate/plate/0/T" "$own/insitu/in_plate.csv" in_plate T
  for table in in_air in_plate; do
    cut -d, -f1,3-7 "$own/insitu/$table.csv" > "$folder/$table.places.$processes"
  done
  [ -s "$own/insitu/both_000020.png" ] || { echo "no frame"; exit 1; }
done
for table in in_air in_plate; do
  cmp "$folder/$table.places.1" "$folder/$table.places.2"
done

# The plate moves by a cell in the second step, the air by two in the third: so much lower is the number of the cell at a place.
run=$folder/moved
make "$run"
cat > "$run/scene.yaml" << 'END'
insitu: 1
probes:
  - {name: in_air, mesh: air, points: [[0.031, 0.017, 0.0123]], fields: [number]}
  - {name: in_plate, mesh: plate, points: [[0.031, 0.017, 0.0087]], fields: [number]}
END
set_entry() {
  foamDictionary -entry "$2" -set "$3" "$1/system/controlDict" >> "$1/log.foamDictionary"
}
set_entry "$run" endTime 0.08
(cd "$run" && "$3" > log 2>&1) || { tail "$run/log"; exit 1; }
numbers() {
  awk -F, 'NR == 1 { for (i = 1; i <= NF; ++i) if ($i == "number") at = i } NR > 1 { printf "%s ", $at }' "$1"
}
set -- "$(numbers "$run/postProcessing/insitu/in_air.csv")" "$(numbers "$run/postProcessing/insitu/in_plate.csv")"
[ "$1 / $2" = "386 386 384 384  / 546 545 545 545 " ] || { echo "cells at the points: air $1, plate $2"; exit 1; }

# expect ENTRY VALUE WORDS: what the log of a run says with such an entry of the function object.
expect() {
  run=$folder/wrong
  rm -rf "$run"
  make "$run"
  set_entry "$run" endTime 0.02
  set_entry "$run" "functions.insitu.$1" "$2"
  (cd "$run" && chtMultiRegionFoam > log 2>&1) || { tail "$run/log"; exit 1; }
  grep -q "function object insitu: $3" "$run/log" || { echo "not said: $3"; grep -A 3 "function object" "$run/log"; exit 1; }
}
expect regions "(air plat)" "there is no region 'plat'; regions are: air plate"
expect regions "(air air)" "the region 'air' stands twice in 'regions'"
expect mesh air "the entries 'regions' and 'mesh' exclude each other"

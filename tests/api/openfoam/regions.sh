#!/bin/sh
# Air over a hot plate by chtMultiRegionFoam, both regions in one session, on one and two processes in strict mode: probes have what
# OpenFOAM's own probes read in each region, cells have the numbers of the whole meshes, and a frame shows both. Where meshes
# move, the session finds each at its new place. Regions that are wrong are named, and the solver goes on.
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

# solve FOLDER PROCESSES SOLVER: with its output in the file log.
solve() {
  if [ "$2" -gt 1 ]; then
    decomposePar -case "$1" -allRegions > "$1/log.decomposePar" 2>&1 || { cat "$1/log.decomposePar"; exit 1; }
    (cd "$1" && mpirun -n "$2" "$3" -parallel > log 2>&1) || { tail "$1/log"; exit 1; }
  else
    (cd "$1" && "$3" > log 2>&1) || { tail "$1/log"; exit 1; }
  fi
}

# set_entry FOLDER ENTRY VALUE: of the case's controlDict.
set_entry() {
  foamDictionary -entry "$2" -set "$3" "$1/system/controlDict" >> "$1/log.foamDictionary"
}

# compare PROBES TABLE COLUMN: OpenFOAM's own probes and the column of the session's table, at both points in each cycle. Both
# print 12 digits or more; 1e-11 of the value is room for the last one.
compare() {
  awk -v column="$3" '
    FNR == NR { gsub(/[()]/, " "); if ($1 !~ /^#/) { n++; for (i = 2; i <= NF; ++i) own[n, i - 1] = $i; width = (NF - 1) / 2 } next }
    FNR == 1 { split($0, names, ","); for (i in names) if (names[i] == column) at = i; next }
    { split($0, v, ","); row = int((FNR - 2) / 2) + 1; which = (FNR - 2) % 2
      offset = column ~ /_y$/ ? 2 : column ~ /_z$/ ? 3 : 1
      want = own[row, which * width + offset]; d = v[at] - want; if (d < 0) d = -d
      if (want == "" || v[at] == "" || d > 1e-11 * (want < 0 ? -want : want)) { print FILENAME " " column " row " FNR ": " v[at] " is not " want; bad = 1 }
      rows++ }
    END { if (bad || !at || rows != 2 * n || n != 20) { print FILENAME " " column ": " rows " rows, " n " of OpenFOAM"; exit 1 } }
  ' "$1" "$2"
}

# cells TABLE: those of its rows.
cells() {
  awk -F, 'NR > 1 { printf "%s ", $4 }' "$1"
}

# expect ENTRY VALUE WORDS: what the log of a run says with such an entry of the function object.
expect() {
  run=$folder/wrong
  rm -rf "$run"
  make "$run"
  set_entry "$run" endTime 0.02
  set_entry "$run" "functions.insitu.$1" "$2"
  solve "$run" 1 chtMultiRegionFoam
  grep -q "function object insitu: $3" "$run/log" || { echo "not said: $3"; grep -A 3 "function object" "$run/log"; exit 1; }
}
case=$1
rm -rf "$2"
mkdir -p "$2"
folder=$(realpath "$2")
for processes in 1 2; do
  run=$folder/$processes
  make "$run"
  solve "$run" "$processes" chtMultiRegionFoam
  if grep "Warning : function object insitu" "$run/log" | grep -v MPI_THREAD_SINGLE; then
    exit 1
  fi
  own=$run/postProcessing
  compare "$own/air/air/0/T" "$own/insitu/in_air.csv" T
  for axis in x y z; do
    compare "$own/air/air/0/U" "$own/insitu/in_air.csv" "U_$axis"
  done
  compare "$own/plate/plate/0/T" "$own/insitu/in_plate.csv" T
  for table in in_air in_plate; do
    cut -d, -f1,3-7 "$own/insitu/$table.csv" > "$folder/$table.places.$processes"
  done
  [ -s "$own/insitu/both_000020.png" ] || { echo "no frame"; exit 1; }
done
for table in in_air in_plate; do
  cmp "$folder/$table.places.1" "$folder/$table.places.2"
done

# The plate moves by a cell in the second step, the air by two in the third: so much lower is the number of the cell at a place.
for processes in 1 2; do
  run=$folder/moved.$processes
  make "$run"
  cat > "$run/scene.yaml" << 'END'
insitu: 1
probes:
  - {name: in_air, mesh: air, points: [[0.031, 0.017, 0.0123]], fields: [number]}
  - {name: in_plate, mesh: plate, points: [[0.031, 0.017, 0.0087]], fields: [number]}
END
  set_entry "$run" endTime 0.08
  solve "$run" "$processes" "$3"
  found="$(cells "$run/postProcessing/insitu/in_air.csv")/ $(cells "$run/postProcessing/insitu/in_plate.csv")"
  [ "$found" = "386 386 384 384 / 546 545 545 545 " ] || { echo "cells in air and plate: $found"; exit 1; }
done

expect regions "(air plat)" "there is no region 'plat'; regions are: air plate"
expect regions "(air air)" "the region 'air' stands twice in 'regions'"
expect regions "()" "the entry 'regions' names no region"
expect mesh air "the entries 'regions' and 'mesh' exclude each other"

#!/bin/sh
# The example's first steps in strict mode, by Code_Saturne on one, two and four processes: nothing is copied and nothing warned
# of; a probe at the centres of all cells has each cell, and the solver's own values there; and with a velocity that does not
# hang on the processes, the tables of gauges and drifters and the frames are the same to the byte.
#   cylinder.sh EXAMPLE FOLDER   77: Code_Saturne is not there
set -e
here=$(dirname "$(realpath "$0")")
for program in code_saturne pkg-config python3; do
  command -v "$program" > /dev/null || { echo "skipped: no $program"; exit 77; }
done
[ -e "$(code_saturne config --datarootdir)/../include/code_saturne/cs_mesh.h" ] || { echo "skipped: no headers of Code_Saturne"; exit 77; }
rm -rf "$2"
mkdir -p "$2/cylinder/SRC"
cp "$here/solver.c" "$2/cylinder/SRC"
cp "$here/scene.yaml" "$2"
cd "$2"
export INSITU_SCENE="$PWD/scene.yaml" CENTRES="$PWD/centres.csv"
for processes in 1 2 4; do
  sh "$1/run.sh" . "$processes" 8
  run=cylinder/RESU/$processes
  if grep -h -A 3 "^insitu: " "$run/listing" "$run/run_solver.log"; then
    exit 1
  fi
  python3 "$here/compare.py" 8 centres.csv "$run/out/cells.csv" "$run"/values.*
  for file in gauges.csv drifters.csv picture_000004.png picture_000008.png; do
    cmp "cylinder/RESU/1/out/$file" "$run/out/$file"
  done
done

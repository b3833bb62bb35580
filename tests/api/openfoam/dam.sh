#!/bin/sh
# The example's first steps in strict mode, by interFoam on one and two processes: nothing is copied, nothing is warned of but what
# OpenFOAM's MPI is, and gauges lie in the same cells at the same places.
#   dam.sh EXAMPLE FOLDER   77: OpenFOAM's programs are not there
set -e
for program in interFoam blockMesh decomposePar mpirun; do
  command -v "$program" > /dev/null || { echo "skipped: no $program"; exit 77; }
done
rm -rf "$2"
for processes in 1 2; do
  sh "$1/run.sh" "$2/$processes" "$processes" 0.03
  log=$2/$processes/log.interFoam
  if grep "Warning : function object insitu" "$log" | grep -v MPI_THREAD_SINGLE; then
    exit 1
  fi
  cut -d, -f1,3-7 "$2/$processes/postProcessing/insitu/gauges.csv" | sed -n 1,6p > "$2/places.$processes"
done
[ "$(wc -l < "$2/places.1")" -eq 6 ] || { echo "no rows of gauges"; exit 1; }
cmp "$2/places.1" "$2/places.2"
! grep -q -- "^4,[0-9]*,-1," "$2/places.1"

#!/bin/bash
# The walk of a query point: lists the files of libinsitu that one call of insitu_mesh_sample enters (tests/layering/walk.c),
# by a trace of all functions, which a build without optimisation does not put in line. It needs valgrind.
#
#   bash tests/layering/walk.sh [build folder]      build/walk
set -euo pipefail
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build/walk}
cmake -S "$root" -B "$build" -G Ninja -DCMAKE_BUILD_TYPE=Debug -DINSITU_UNITY=ON -DINSITU_WITH_CUDA=OFF > /dev/null
cmake --build "$build" --target insitu > /dev/null
cc -O1 -g "$root/tests/layering/walk.c" -I"$root/libinsitu/include" -L"$build/lib" -linsitu -Wl,-rpath,"$build/lib" -o "$build/walk"
valgrind --tool=callgrind --toggle-collect=insitu_mesh_sample --callgrind-out-file="$build/walk.out" "$build/walk" > /dev/null 2>&1
# Names are written once, with a number that stands for them from then on; lines of calls (cfi, cfl) name who is called.
awk '
  match($0, /^c?f[lie]=\([0-9]+\)/) {
    id = substr($0, RSTART, RLENGTH); sub(/^[^(]*/, "", id)
    name = substr($0, RLENGTH + 2)
    if (name != "") names[id] = name
    if ($0 !~ /^c/) entered[id] = 1
  }
  END { for (id in entered) if (sub(/.*\/libinsitu\//, "libinsitu/", names[id])) print names[id] }
' "$build/walk.out" | sort -u > "$build/walk.txt"
cat "$build/walk.txt"
echo "$(wc -l < "$build/walk.txt") files"

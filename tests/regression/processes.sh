#!/usr/bin/env bash
# Runs a case of tests/regression/cases alone and on several processes, and compares what is written, byte by byte.
#   processes.sh --bin DIR --work DIR [--only REGEX] [--thin] [--stop CYCLE | --replay] CASE N [N ...]
# --bin: where the miniapps are; --work: a folder to run in, emptied first; --only: the files to compare, such as
# 'gauges|blast_' (all tables and images); N: numbers of processes. With --thin the scene is changed by the case's `thin` (sed), so that
# it costs less. With --stop, which the miniapp has to know, a run stops some
# cycles after that one, on each of N, and goes on on the next of N from the checkpoint of that cycle; the last ends the run.
# With --replay every cycle is recorded on each of N processes (1: without MPI), and what insitu-replay makes of the records is
# compared with what the run alone wrote.
# Exit code: 0 same, 1 different, 2 could not run.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
bin= work= only=. stop= replay= thinned=
while [ $# -gt 0 ]; do
  case $1 in
    --bin) bin=$(cd "$2" && pwd); shift 2 ;;
    --work) work=$2; shift 2 ;;
    --only) only=$2; shift 2 ;;
    --stop) stop=$2; shift 2 ;;
    --replay) replay=1; shift ;;
    --thin) thinned=1; shift ;;
    --help|-h) sed -n '2,10s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"; exit 0 ;;
    -*) echo "processes.sh: no option '$1'; see --help" >&2; exit 2 ;;
    *) break ;;
  esac
done
[ $# -gt 1 ] && [ -n "$bin" ] && [ -n "$work" ] || { echo "processes.sh: see --help" >&2; exit 2; }
name=$1
shift
source "$here/cases/$name/case.sh"
rm -rf "$work"
mkdir -p "$work"
export OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1

scene=$work/scene.yaml more=()
cp "$here/cases/$name/scene.yaml" "$scene"
if [ -n "$thinned" ]; then
  sed -i "${thin[@]}" "$scene"
  ! cmp -s "$here/cases/$name/scene.yaml" "$scene" || { echo "processes.sh: $name is not thinned" >&2; exit 2; }
fi
run() { # folder, launcher ...
  local folder=$work/$1
  shift
  timeout 100 "$@" "$bin/$program" "${arguments[@]}" "${more[@]}" --scene "$scene" --output "$folder" \
    > "$folder.log" 2>&1 || { cat "$folder.log" >&2; echo "processes.sh: $program failed ($*)" >&2; exit 2; }
}
files() { # of a folder, but for those that hold seconds
  (cd "$1" && find . -type f ! -name '*.js' ! -name '*.html' ! -name summary.json ! -name '*.insitu*' ! -name '*.hdf*' | { grep -E "$only" || true; } | sort)
}

run alone env
[ -n "$(files "$work/alone")" ] || { echo "processes.sh: no file matches '$only'" >&2; exit 2; }
different=0
if [ -n "$stop" ]; then # the same folder for all
  printf 'checkpoint: {every: %s, keep: 2}\n' "$stop" >> "$scene"
  more=(--cycles $((stop + 3)))
  for processes in "${@:1:$#-1}"; do
    run stopped mpirun -n "$processes"
    more=(--cycles $((stop + 3)) --from "$stop" --restart "$work/stopped/checkpoint_$(printf %06d "$stop").insitu")
  done
  more=("${more[@]:2}")
  run stopped mpirun -n "${@: -1}"
  while read -r file; do
    cmp "$work/alone/$file" "$work/stopped/$file" || different=1
  done < <({ files "$work/alone"; files "$work/stopped"; } | sort -u)
  [ $different = 0 ] && echo "$name: $(files "$work/alone" | wc -l) files are the same without a stop and stopped on $* processes"
  exit $different
fi
if [ -n "$replay" ]; then
  printf 'record: {every: 1}\n' >> "$scene"
  for processes in "$@"; do
    launch=(mpirun -n "$processes")
    [ "$processes" -gt 1 ] || launch=(env)
    run "on_$processes" "${launch[@]}"
    timeout 100 "$bin/insitu-replay" --out "$work/again_$processes" "$work/on_$processes/record.hdf.series" || exit 2
    while read -r file; do
      cmp "$work/alone/$file" "$work/again_$processes/$file" || different=1
    done < <({ files "$work/alone"; files "$work/again_$processes"; } | sort -u)
  done
  [ $different = 0 ] && echo "$name: $(files "$work/alone" | wc -l) files are the same alone and replayed from records on $* processes"
  exit $different
fi
for processes in "$@"; do
  run "on_$processes" mpirun -n "$processes"
  while read -r file; do
    cmp "$work/alone/$file" "$work/on_$processes/$file" || different=1
  done < <({ files "$work/alone"; files "$work/on_$processes"; } | sort -u)
done
[ $different = 0 ] && echo "$name: $(files "$work/alone" | wc -l) files are the same alone and on $* processes"
exit $different

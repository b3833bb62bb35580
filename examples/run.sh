#!/usr/bin/env bash
# Sets up, builds and runs the main jobs on a bare Debian 12: the Sedov blast wave, a blast on an adaptive grid, and
# the circulation of an ocean basin.
#   bash examples/run.sh [--no-install] [--processes N] [sedov options, such as --cells 30; see sedov --help]
# --processes N: each of them as N processes of MPI, by mpirun; more than there are cores too, and as root.
set -euo pipefail
source "$(dirname "$0")/../cmake/setup.sh"

no_install=0
processes=
arguments=()
while [ $# -gt 0 ]; do
  case $1 in
    --help|-h) sed -n '2,5s/^# //p' "$0"; exit 0 ;;
    --no-install) no_install=1 ;;
    --processes)
      [[ ${2:-} =~ ^[1-9][0-9]*$ ]] || { echo "run.sh: --processes: a whole number of at least 1 expected" >&2; exit 2; }
      processes=$2
      shift ;;
    *) arguments+=("$1") ;;
  esac
  shift
done

say "libinsitu: the main jobs"
ensure_packages "${packages[@]}"
configure_and_build release -DINSITU_BUILD_TESTS=OFF -- sedov amr_blast gyre ${processes:+insitu_mpi}
cd "$project"
run() { # a miniapp and its options
  if [ -n "$processes" ]; then
    # Open MPI asks for leave to run as root, and to run more processes than there are cores.
    OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 OMPI_MCA_rmaps_base_oversubscribe=1 \
      mpirun -n "$processes" "./build/release/bin/$1" "${@:2}"
  else
    "./build/release/bin/$1" "${@:2}"
  fi
}
run sedov --scene examples/sedov/scene.yaml --output out/sedov \
  --material 1000 "${arguments[@]}"
say "written: out/sedov (frames, probe and tracer tables, summary.json)"
run amr_blast --scene examples/amr_blast/scene.yaml --output out/amr_blast --quiet
say "written: out/amr_blast (the same)"
run gyre --scene examples/gyre/scene.yaml --output out/gyre --quiet
say "written: out/gyre (the same, on Earth)"

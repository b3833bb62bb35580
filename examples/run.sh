#!/usr/bin/env bash
# Sets up, builds and runs the main jobs on a bare Debian 12: the Sedov blast wave, a blast on an adaptive grid, and
# the circulation of an ocean basin.
#   bash examples/run.sh [--no-install] [sedov options, such as --cells 30; see sedov --help]
set -euo pipefail
source "$(dirname "$0")/../cmake/setup.sh"

no_install=0
arguments=()
while [ $# -gt 0 ]; do
  case $1 in
    --help|-h) sed -n '2,4s/^# //p' "$0"; exit 0 ;;
    --no-install) no_install=1 ;;
    *) arguments+=("$1") ;;
  esac
  shift
done

say "libinsitu: the main jobs"
ensure_packages "${packages[@]}"
configure_and_build release -DINSITU_BUILD_TESTS=OFF -- sedov amr_blast gyre
cd "$project"
./build/release/bin/sedov --scene examples/sedov/scene.yaml --output out/sedov \
  --material 1000 "${arguments[@]}"
say "written: out/sedov (frames, probe and tracer tables, summary.json)"
./build/release/bin/amr_blast --scene examples/amr_blast/scene.yaml --output out/amr_blast --quiet
say "written: out/amr_blast (the same)"
./build/release/bin/gyre --scene examples/gyre/scene.yaml --output out/gyre --quiet
say "written: out/gyre (the same, on Earth)"

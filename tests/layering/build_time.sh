#!/usr/bin/env bash
# Compiles the sources of frames' integrators anew, without a cache, and fails if one of them takes
# longer than the ceiling in seconds of a processor. The ceiling is about three times what the
# slowest took when it was set, so that slower machines pass; integrators.cmake holds the cause, the
# code that is instantiated, exactly.
#
#   bash tests/layering/build_time.sh BUILD_FOLDER [CEILING]
set -euo pipefail
build=$1
ceiling=${2:-60}
object=$(mktemp)
trap 'rm -f "$object"' EXIT
failed=0
for source in volume/volume volume/volume_gather volume/volume_levels volume/volume_shadow path/path_tracer \
              path/path_wave surface/isosurface surface/cell_roots surface/surfaces surface/shade; do
  # The command of a source that is compiled by itself, however others are grouped; the last one
  # makes the object, those before it are of what it depends on.
  target=libinsitu/CMakeFiles/insitu_objects.dir/src/render/path/path_tracer.cpp.o
  command=$(ninja -C "$build" -t commands "$target" | tail -1 |
            sed -e 's/^[^ ]*ccache //' -e "s| -o $target| -o $object|" -e 's/ -MD -MT [^ ]* -MF [^ ]*//' \
                -e "s|render/path/path_tracer.cpp|render/$source.cpp|")
  seconds=$(cd "$build" && { TIMEFORMAT=%U; time eval "$command" 2>&1 >&3; } 3>&1 2>&1 | tail -1)
  verdict=
  if awk "BEGIN { exit !($seconds > $ceiling) }"; then
    verdict="  more than the ceiling of $ceiling s"
    failed=1
  fi
  printf '%-24s %7.1f s%s\n' "$source" "$seconds" "$verdict"
done
exit $failed

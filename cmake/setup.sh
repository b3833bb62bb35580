# Sourced by examples/run.sh and tests/run.sh: installs what is missing, configures, builds.
# Quiet unless something fails: output goes to build/<preset>/*.log.

project=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

# Debian 12 packages, and what each is for.
packages=(
  "cmake:builds the project"
  "ninja-build:builds the project"
  "g++:C and C++ compiler"
  "gfortran:Fortran module, the heat and gyre miniapps"
  "libtbb-dev:threads"
  "libembree-dev:BVH builder"
  "libhwy-dev:SIMD with run-time dispatch"
  "libyaml-cpp-dev:scene files"
  "libpng-dev:frames"
  "libopenexr-dev:frames in floating point"
  "libgeographiclib-dev:frames of reference on Earth"
  "libnetcdf-dev:tracks and probes in netCDF"
  "libhdf5-dev:records of runs"
  "nlohmann-json3-dev:figures of insitu-bench, dumps of Catalyst in insitu-replay"
  "libp4est-dev:p4est adaptor and the amr_blast miniapp"
  "mpi-default-dev:sessions of several processes; headers that those of p4est need"
  "libvtk9-dev:VTK adaptor, insitu-replay, second opinion in tests"
)
test_packages=(
  "libgtest-dev:unit tests"
  "libboost-dev:exact rational oracle in tests"
  "pkg-config:test of the installed package"
  "make:test of the installed package"
)

# Beyond what tests/gpu needs: 122 MB to fetch.
browser_packages=(
  "chromium:test of the page of a run, without a window"
)

say() { printf '%s\n' "$*"; }

# step "what" command...: runs it with output to the log; on a terminal shows that it is going on.
step() {
  local what=$1 log=$2 start=$SECONDS
  shift 2
  mkdir -p "$(dirname "$log")"
  if [ -t 1 ]; then printf '  %s ...' "$what"; fi
  if "$@" > "$log" 2>&1; then
    if [ -t 1 ]; then printf '\r'; fi
    printf '  %-44s %4d s\n' "$what" $((SECONDS - start))
  else
    local status=$?
    printf '\n'
    say "failed: $what (status $status). The end of $log:"
    tail -n 40 "$log"
    return "$status"
  fi
}

# ensure_packages NAME:WHY...: asks apt once for what is missing.
ensure_packages() {
  local missing=() entry name
  for entry in "$@"; do
    name=${entry%%:*}
    if ! dpkg-query -W -f='${Status}' "$name" 2>/dev/null | grep -q 'ok installed'; then
      missing+=("$name")
      say "  missing: $name (${entry#*:})"
    fi
  done
  [ ${#missing[@]} -eq 0 ] && return 0
  if [ "${no_install:-0}" = 1 ]; then
    say "not installing (--no-install); install them with: apt-get install ${missing[*]}"
    return 1
  fi
  if ! command -v apt-get > /dev/null; then
    say "no apt-get here; install the packages above by your system's means"
    return 1
  fi
  local sudo=()
  [ "$(id -u)" = 0 ] || sudo=(sudo)
  step "apt-get update" "$project/build/apt-update.log" "${sudo[@]}" apt-get update
  step "apt-get install ${#missing[@]} packages" "$project/build/apt-install.log" \
    "${sudo[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends \
    "${missing[@]}"
}

# configure_and_build PRESET [cmake options] -- [targets]
configure_and_build() {
  local preset=$1 options=() targets=()
  shift
  while [ $# -gt 0 ] && [ "$1" != -- ]; do options+=("$1"); shift; done
  [ $# -gt 0 ] && shift
  [ $# -gt 0 ] && targets=(--target "$@")
  cd "$project"
  step "configure ($preset)" "build/$preset/configure.log" \
    cmake --preset "$preset" "${options[@]}" || return
  grep -h '^-- insitu:' "build/$preset/configure.log" || true
  step "build ($preset)" "build/$preset/build.log" \
    cmake --build --preset "$preset" "${targets[@]}"
}

#!/usr/bin/env bash
# Copies the public headers, the Fortran module and the list of struct members to tests/abi/<version>: README.md says when.
set -euo pipefail
cd "$(dirname "$0")"
to=${1:?usage: freeze.sh <major.minor>}
root=../..
rm -rf "$to/include" "$to/module"
mkdir -p "$to/include" "$to/module"
cp -r $root/libinsitu/include/insitu "$to/include/"
cp $root/adaptors/fortran/*.f90 $root/adaptors/fortran/*.inc "$to/module/"
cp $root/tests/api/fortran/layout.c "$to/layout.c"

#!/bin/sh
# Water flows past a cylinder, in Code_Saturne with libinsitu's file in the case's SRC.
#   run.sh FOLDER [PROCESSES [STEPS]]   makes a study there and runs its case, in strict mode if STEPS are given; pkg-config has
#                                       to find libinsitu (PKG_CONFIG_PATH)
set -e
example=$(dirname "$(realpath "$0")")
mkdir -p "${1:?a folder for the study}/MESH" "$1/cylinder/SRC" "$1/cylinder/RESU"
processes=${2:-1}
export USER="${USER:-$(id -un)}" # which Code_Saturne's scripts need
cd "$1"
python3 "$example/mesh.py" MESH/cylinder.msh
cp -r "$example/case/DATA" cylinder
cp "$example/../../adaptors/saturne/cs_user_extra_operations.c" cylinder/SRC
cd cylinder
if [ -n "$3" ]; then
  export INSITU_STRICT=1
  sed -i "s|<iterations>.*<|<iterations>$3<|" DATA/setup.xml
fi
code_saturne run --param setup.xml --id "$processes" -n "$processes" > "RESU/log.$processes" || {
  cat "RESU/log.$processes"
  exit 1
}

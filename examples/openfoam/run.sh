#!/bin/sh
# A dam breaks on an obstacle, with interFoam as it comes and libinsitu's function object in system/controlDict.
#   run.sh FOLDER [PROCESSES [END]]   copies the case there and runs it, to that time; libinsituFoam.so has to be found (LD_LIBRARY_PATH)
set -e
case=$(dirname "$(realpath "$0")")
folder=${1:?a folder for the run}
processes=${2:-1}
# Debian's OpenFOAM is not told where its own files are.
if [ -z "$WM_PROJECT_DIR" ] && [ -d /usr/share/openfoam ]; then
  export WM_PROJECT_DIR=/usr/share/openfoam
fi
mkdir -p "$folder"
cp -r "$case/constant" "$case/system" "$case/scene.yaml" "$folder"
cp -r "$case/0.orig" "$folder/0"
cd "$folder"
if [ -n "$3" ]; then
  foamDictionary -entry endTime -set "$3" system/controlDict > log.foamDictionary
  foamDictionary -entry functions.insitu.strict -set true system/controlDict >> log.foamDictionary
fi
for step in "blockMesh" "topoSet" "subsetMesh -overwrite -patch obstacle all" "topoSet -dict system/topoSetDict.refined" \
            "refineHexMesh -overwrite near" "setFields"; do
  $step > "log.${step%% *}" 2>&1 || { cat "log.${step%% *}"; exit 1; }
done
if [ "$processes" -gt 1 ]; then
  foamDictionary -entry numberOfSubdomains -set "$processes" system/decomposeParDict >> log.foamDictionary
  foamDictionary -entry coeffs.n -set "($processes 1 1)" system/decomposeParDict >> log.foamDictionary
  decomposePar > log.decomposePar
  mpirun -n "$processes" interFoam -parallel > log.interFoam
else
  interFoam > log.interFoam
fi

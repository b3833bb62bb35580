#!/bin/sh
# no_library.sh FOLDER PROGRAM: the program; on the process of rank 1 with libinsitu from the folder, where libinsitu-mpi is not,
# and without the folders of LD_LIBRARY_PATH that have that library.
if [ "${PMIX_RANK:-${OMPI_COMM_WORLD_RANK:-$PMI_RANK}}" = 1 ]; then
  kept=$1
  IFS=:
  for folder in $LD_LIBRARY_PATH; do
    ls "$folder"/libinsitu-mpi.so.* > /dev/null 2>&1 || kept=$kept:$folder
  done
  export LD_LIBRARY_PATH="$kept"
fi
exec "$2"

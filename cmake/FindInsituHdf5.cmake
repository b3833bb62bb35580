# Finds HDF5's C library, the one without MPI, and makes the target InsituHdf5::InsituHdf5 (CMake's own FindHDF5 takes whichever
# of Debian's two comes first, and shares its variables with VTK's).
find_path(InsituHdf5_INCLUDE_DIR NAMES hdf5.h PATH_SUFFIXES hdf5/serial)
find_library(InsituHdf5_LIBRARY NAMES hdf5_serial hdf5)
if(InsituHdf5_INCLUDE_DIR)
  file(GLOB config ${InsituHdf5_INCLUDE_DIR}/H5pubconf*.h)
  set(lines "")
  foreach(file ${config})
    file(STRINGS ${file} some REGEX "define (H5_)?(PACKAGE_VERSION|HAVE_PARALLEL) ")
    list(APPEND lines ${some})
  endforeach()
  string(REGEX MATCH "PACKAGE_VERSION \"([0-9.]+)" matched "${lines}")
  set(InsituHdf5_VERSION ${CMAKE_MATCH_1})
  if(NOT lines MATCHES "HAVE_PARALLEL 1")
    set(InsituHdf5_IS_SERIAL TRUE)
  endif()
endif()
include(FindPackageHandleStandardArgs)
# From 1.10.7 on a program says itself whether a file is locked.
if(InsituHdf5_VERSION AND InsituHdf5_VERSION VERSION_LESS 1.10.7)
  set(InsituHdf5_IS_SERIAL FALSE)
endif()
find_package_handle_standard_args(InsituHdf5
  REQUIRED_VARS InsituHdf5_LIBRARY InsituHdf5_INCLUDE_DIR InsituHdf5_IS_SERIAL VERSION_VAR InsituHdf5_VERSION
  REASON_FAILURE_MESSAGE "records are written with HDF5 1.10.7 or later without MPI: apt-get install libhdf5-dev")
if(InsituHdf5_FOUND AND NOT TARGET InsituHdf5::InsituHdf5)
  add_library(InsituHdf5::InsituHdf5 UNKNOWN IMPORTED)
  set_target_properties(InsituHdf5::InsituHdf5 PROPERTIES
    IMPORTED_LOCATION ${InsituHdf5_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${InsituHdf5_INCLUDE_DIR})
endif()
mark_as_advanced(InsituHdf5_INCLUDE_DIR InsituHdf5_LIBRARY)

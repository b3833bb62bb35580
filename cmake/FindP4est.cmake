# Finds p4est and makes the target P4est::p4est (Debian ships no package configuration). If p4est was
# built with MPI, its headers need MPI's.
find_path(P4est_INCLUDE_DIR NAMES p8est.h)
find_library(P4est_LIBRARY NAMES p4est)
find_library(P4est_SC_LIBRARY NAMES sc)
set(needed P4est_LIBRARY P4est_SC_LIBRARY P4est_INCLUDE_DIR)
set(P4est_WITH_MPI FALSE)
if(P4est_INCLUDE_DIR AND EXISTS ${P4est_INCLUDE_DIR}/p4est_config.h)
  file(STRINGS ${P4est_INCLUDE_DIR}/p4est_config.h line REGEX "define P4EST_VERSION ")
  string(REGEX MATCH "[0-9]+\\.[0-9]+(\\.[0-9]+)?" P4est_VERSION "${line}")
  file(STRINGS ${P4est_INCLUDE_DIR}/p4est_config.h line REGEX "define P4EST_ENABLE_MPI 1")
  if(line)
    set(P4est_WITH_MPI TRUE)
    find_package(MPI QUIET COMPONENTS C)
    list(APPEND needed MPI_C_FOUND)
  endif()
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(P4est REQUIRED_VARS ${needed} VERSION_VAR P4est_VERSION)
if(P4est_FOUND AND NOT TARGET P4est::p4est)
  add_library(P4est::p4est UNKNOWN IMPORTED)
  set_target_properties(P4est::p4est PROPERTIES
    IMPORTED_LOCATION ${P4est_LIBRARY}
    # MPI's own C++ bindings need a library that nobody links.
    INTERFACE_COMPILE_DEFINITIONS "OMPI_SKIP_MPICXX=1;MPICH_SKIP_MPICXX=1"
    INTERFACE_INCLUDE_DIRECTORIES ${P4est_INCLUDE_DIR}
    INTERFACE_LINK_LIBRARIES "${P4est_SC_LIBRARY};$<$<BOOL:${P4est_WITH_MPI}>:MPI::MPI_C>")
endif()
mark_as_advanced(P4est_INCLUDE_DIR P4est_LIBRARY P4est_SC_LIBRARY)

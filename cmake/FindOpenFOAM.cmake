# OpenFOAM::finiteVolume, OpenFOAM_API (such as 1912): OpenFOAM of openfoam.com, its sources with their lnInclude folders and its
# libraries. Hints: OpenFOAM_ROOT, or the environment of an OpenFOAM (FOAM_SRC, FOAM_LIBBIN).
find_path(OpenFOAM_SOURCE finiteVolume/lnInclude/fvMesh.H HINTS ${OpenFOAM_ROOT}/src $ENV{FOAM_SRC})
find_library(OpenFOAM_LIBRARY OpenFOAM HINTS $ENV{FOAM_LIBBIN})
find_library(OpenFOAM_finiteVolume_LIBRARY finiteVolume HINTS $ENV{FOAM_LIBBIN})
mark_as_advanced(OpenFOAM_SOURCE OpenFOAM_LIBRARY OpenFOAM_finiteVolume_LIBRARY)

if(OpenFOAM_SOURCE AND EXISTS ${OpenFOAM_SOURCE}/../META-INFO/api-info)
  file(STRINGS ${OpenFOAM_SOURCE}/../META-INFO/api-info api REGEX "^api=")
  string(REPLACE "api=" "" OpenFOAM_API "${api}")
endif()

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(OpenFOAM REQUIRED_VARS OpenFOAM_SOURCE OpenFOAM_LIBRARY OpenFOAM_finiteVolume_LIBRARY
                                                         OpenFOAM_API)

if(OpenFOAM_FOUND AND NOT TARGET OpenFOAM::finiteVolume)
  add_library(OpenFOAM::finiteVolume INTERFACE IMPORTED)
  # Sizes of labels and scalars are those of the environment, or OpenFOAM's own defaults.
  set(label $ENV{WM_LABEL_SIZE})
  set(precision $ENV{WM_PRECISION_OPTION})
  if(NOT label)
    set(label 32)
  endif()
  if(NOT precision)
    set(precision DP)
  endif()
  target_compile_definitions(OpenFOAM::finiteVolume INTERFACE OPENFOAM=${OpenFOAM_API} WM_${precision} WM_LABEL_SIZE=${label}
                                                              NoRepository
                             # MPI's own C++ bindings need a library that nobody links.
                             OMPI_SKIP_MPICXX=1 MPICH_SKIP_MPICXX=1)
  foreach(part OpenFOAM OSspecific/POSIX finiteVolume meshTools)
    target_include_directories(OpenFOAM::finiteVolume SYSTEM INTERFACE ${OpenFOAM_SOURCE}/${part}/lnInclude)
  endforeach()
  target_include_directories(OpenFOAM::finiteVolume SYSTEM INTERFACE ${OpenFOAM_SOURCE}/Pstream/mpi)
  target_link_libraries(OpenFOAM::finiteVolume INTERFACE ${OpenFOAM_finiteVolume_LIBRARY} ${OpenFOAM_LIBRARY})
endif()

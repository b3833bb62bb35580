# Finds Embree 4 or 3 (EMBREE_ROOT is searched first) and makes the target Embree::Embree.
find_path(EMBREE_INCLUDE_DIR NAMES embree4/rtcore.h embree3/rtcore.h HINTS ${EMBREE_ROOT}
          PATH_SUFFIXES include)
find_library(EMBREE_LIBRARY NAMES embree4 embree3 HINTS ${EMBREE_ROOT} PATH_SUFFIXES lib lib64)
if(EMBREE_INCLUDE_DIR)
  foreach(major 4 3)
    foreach(file rtcore_config.h rtcore_version.h)
      set(path ${EMBREE_INCLUDE_DIR}/embree${major}/${file})
      if(NOT EMBREE_VERSION AND EXISTS ${path})
        file(STRINGS ${path} line REGEX "define RTC_VERSION_STRING")
        string(REGEX MATCH "[0-9]+\\.[0-9]+\\.[0-9]+" EMBREE_VERSION "${line}")
      endif()
    endforeach()
  endforeach()
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(Embree REQUIRED_VARS EMBREE_LIBRARY EMBREE_INCLUDE_DIR
                                  VERSION_VAR EMBREE_VERSION)
if(Embree_FOUND AND NOT TARGET Embree::Embree)
  add_library(Embree::Embree UNKNOWN IMPORTED)
  set_target_properties(Embree::Embree PROPERTIES IMPORTED_LOCATION ${EMBREE_LIBRARY}
                        INTERFACE_INCLUDE_DIRECTORIES ${EMBREE_INCLUDE_DIR})
endif()
mark_as_advanced(EMBREE_INCLUDE_DIR EMBREE_LIBRARY)

# Finds netCDF-C and makes the target NetCDF::NetCDF (its own package configuration looks for HDF5's
# development files, which the classic formats do not need).
find_path(NetCDF_INCLUDE_DIR NAMES netcdf.h)
find_library(NetCDF_LIBRARY NAMES netcdf)
if(NetCDF_INCLUDE_DIR AND EXISTS ${NetCDF_INCLUDE_DIR}/netcdf_meta.h)
  file(STRINGS ${NetCDF_INCLUDE_DIR}/netcdf_meta.h line REGEX "define NC_VERSION ")
  string(REGEX MATCH "[0-9]+\\.[0-9]+(\\.[0-9]+)?" NetCDF_VERSION "${line}")
  file(STRINGS ${NetCDF_INCLUDE_DIR}/netcdf_meta.h line REGEX "define NC_HAS_CDF5 +1")
  if(line)
    set(NetCDF_HAS_CDF5 TRUE)
  endif()
endif()
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(NetCDF
  REQUIRED_VARS NetCDF_LIBRARY NetCDF_INCLUDE_DIR NetCDF_HAS_CDF5 VERSION_VAR NetCDF_VERSION
  REASON_FAILURE_MESSAGE "tracks and probes are written with netCDF-C built with CDF-5: apt-get install libnetcdf-dev")
if(NetCDF_FOUND AND NOT TARGET NetCDF::NetCDF)
  add_library(NetCDF::NetCDF UNKNOWN IMPORTED)
  set_target_properties(NetCDF::NetCDF PROPERTIES
    IMPORTED_LOCATION ${NetCDF_LIBRARY}
    INTERFACE_INCLUDE_DIRECTORIES ${NetCDF_INCLUDE_DIR})
endif()
mark_as_advanced(NetCDF_INCLUDE_DIR NetCDF_LIBRARY)

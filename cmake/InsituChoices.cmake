# The options that say whether an optional part is built. Another word would be taken for AUTO by one and for ON by another.
foreach(part VTK HDF5 P4EST FORTRAN MPI OPENFOAM)
  if(DEFINED INSITU_WITH_${part} AND NOT INSITU_WITH_${part} MATCHES "^(AUTO|ON|OFF)$")
    message(FATAL_ERROR "insitu: INSITU_WITH_${part} is '${INSITU_WITH_${part}}', AUTO, ON or OFF expected")
  endif()
endforeach()

# Configures a small project with each word of INSITU_WITH_MPI, where CMake finds an MPI and where it finds none.
file(REMOVE_RECURSE ${WORK})
file(MAKE_DIRECTORY ${WORK}/project)
file(WRITE ${WORK}/project/CMakeLists.txt "
cmake_minimum_required(VERSION 3.22)
project(options LANGUAGES C)
list(APPEND CMAKE_MODULE_PATH ${SOURCE}/cmake)
include(InsituChoices)
include(InsituMpi)
message(STATUS \"has MPI: \${INSITU_HAVE_MPI}\")
if(TARGET MPI::MPI_C AND NOT INSITU_HAVE_MPI)
  message(FATAL_ERROR \"MPI was looked for\")
endif()
")

# expect(word hidden fails text): what configuring with the word says; hidden: CMake finds no MPI.
function(expect word hidden fails text)
  execute_process(COMMAND ${CMAKE_COMMAND} -S ${WORK}/project -B ${WORK}/build -G ${GENERATOR} -DCMAKE_MAKE_PROGRAM=${MAKE_PROGRAM}
                          -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_DISABLE_FIND_PACKAGE_MPI=${hidden} -DINSITU_WITH_MPI=${word}
                  OUTPUT_VARIABLE out ERROR_VARIABLE out RESULT_VARIABLE result)
  string(REGEX REPLACE "[ \n]+" " " out "${out}")
  if((result EQUAL 0) STREQUAL fails OR NOT out MATCHES "${text}")
    message(SEND_ERROR "INSITU_WITH_MPI=${word}, without MPI: ${hidden}: '${text}' expected, got ${result}: ${out}")
  endif()
endfunction()

expect(OFF OFF FALSE "has MPI: FALSE")
expect(AUTO ON FALSE "insitu: no MPI - no libinsitu-mpi, sessions are serial.*has MPI: FALSE")
expect(ON ON TRUE "insitu: INSITU_WITH_MPI is ON and no MPI was found")
expect(off OFF TRUE "insitu: INSITU_WITH_MPI is 'off', AUTO, ON or OFF expected")
if(HAS_MPI)
  expect(AUTO OFF FALSE "has MPI: TRUE")
  expect(ON OFF FALSE "has MPI: TRUE")
endif()

# libcatalyst-insitu.so in an installation that was moved. Variables as package.cmake sets them, and CATALYST_PROGRAM.

# check_catalyst(): the library is there, a solver that speaks Catalyst 2 loads it by name, and it takes the libinsitu
# beside it, with which the solver's run makes a probe's table.
function(check_catalyst)
  set(folder ${prefix}/${LIBDIR}/catalyst)
  if(NOT EXISTS ${folder}/libcatalyst-insitu.so)
    message(FATAL_ERROR "${folder} has no libcatalyst-insitu.so, which every build makes")
  endif()
  if(NOT CATALYST_PROGRAM)
    message(STATUS "libcatalyst-insitu.so is not loaded: examples/catalyst was not built")
    return()
  endif()
  set(table ${WORK}/catalyst/gauges.csv)
  file(WRITE ${WORK}/catalyst.yaml "insitu: 1\noutput: ${WORK}/catalyst\nprobes:\n"
       "  - {name: gauges, mesh: grid, points: [[0.5, 0.75, 0.1]], fields: [dye], every: 30}\n")
  execute_process(COMMAND ${CMAKE_COMMAND} -E env --unset=LD_LIBRARY_PATH --unset=INSITU_SCENE LD_DEBUG=libs
                          CATALYST_IMPLEMENTATION_NAME=insitu CATALYST_IMPLEMENTATION_PATHS=${folder}
                          ${CATALYST_PROGRAM} ${WORK}/catalyst.yaml
                  RESULT_VARIABLE status OUTPUT_VARIABLE text ERROR_VARIABLE text)
  string(FIND "${text}" "calling init: ${folder}/../libinsitu.so" beside)
  if(NOT status EQUAL 0 OR beside EQUAL -1 OR NOT EXISTS ${table})
    string(REGEX MATCHALL "[^\n]*(insitu|atalyst)[^\n]*" lines "${text}")
    string(REPLACE ";" "\n  " lines "${lines}")
    message(FATAL_ERROR "${CATALYST_PROGRAM} with ${folder} (${status}) took another libinsitu or made no ${table}:\n  ${lines}")
  endif()
endfunction()

# Installs the build into a folder of its own, then builds and runs the numbered examples against it
# as a user would: find_package, and pkg-config. Variables: BUILD, SOURCE, WORK, LIBDIR, C_COMPILER,
# CXX_COMPILER, GENERATOR, CONFIGURATION, LINKER_FLAGS.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT status EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "${command}\n${text}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
set(prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})

set(languages c cpp)
if(FORTRAN)
  list(APPEND languages fortran)
endif()
foreach(language ${languages})
  run(${CMAKE_COMMAND} -S ${SOURCE}/examples/${language} -B ${WORK}/${language} -G ${GENERATOR}
      -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_BUILD_TYPE=${CONFIGURATION}
      -DCMAKE_C_COMPILER=${C_COMPILER} -DCMAKE_CXX_COMPILER=${CXX_COMPILER}
      -DCMAKE_EXE_LINKER_FLAGS=${LINKER_FLAGS})
  # The package was found where it was installed, not in the tree.
  file(STRINGS ${WORK}/${language}/CMakeCache.txt found REGEX "^insitu_DIR:")
  if(NOT found MATCHES "${prefix}/")
    message(FATAL_ERROR "found another package: ${found}")
  endif()
  run(${CMAKE_COMMAND} --build ${WORK}/${language})
  run(${CMAKE_CTEST_COMMAND} --test-dir ${WORK}/${language} --output-on-failure)
endforeach()

find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  # The folder was renamed at installation, so the prefix is given anew.
  execute_process(COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${prefix}/${LIBDIR}/pkgconfig
                          ${PKG_CONFIG} --define-variable=prefix=${prefix} --cflags --libs insitu
                  RESULT_VARIABLE status OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE)
  if(NOT status EQUAL 0)
    message(FATAL_ERROR "pkg-config does not know insitu")
  endif()
  separate_arguments(flags UNIX_COMMAND "${flags}")
  separate_arguments(linker_flags UNIX_COMMAND "${LINKER_FLAGS}")
  run(${C_COMPILER} -std=c99 ${SOURCE}/examples/c/02_probe.c -o ${WORK}/by_pkg_config ${flags}
      ${linker_flags} -I${prefix}/include -L${prefix}/${LIBDIR} -lm)
  run(${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${prefix}/${LIBDIR} ${WORK}/by_pkg_config)
endif()

if(EXISTS ${prefix}/bin/insitu-replay)
  run(${prefix}/bin/insitu-replay --version)
endif()
file(REMOVE_RECURSE ${WORK})

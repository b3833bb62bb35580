# Installs the build into a folder of its own and moves that, then builds and runs programs against it as a user would:
# the numbered examples by find_package, and by pkg-config what README.md shows, examples/Makefile in it. Variables:
# BUILD, SOURCE, WORK, LIBDIR, DOCDIR, C_COMPILER, CXX_COMPILER, Fortran_COMPILER (if the module was built), GENERATOR,
# CONFIGURATION, LINKER_FLAGS, MPI_PROGRAM (a program on MPI, if that was found), CATALYST_PROGRAM (examples/catalyst).
cmake_minimum_required(VERSION 3.22)
include(${CMAKE_CURRENT_LIST_DIR}/catalyst.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/pkg_config.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/pages.cmake)

# run(command...): a command that has to succeed.
function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE status OUTPUT_VARIABLE text ERROR_VARIABLE text)
  if(NOT status EQUAL 0)
    string(REPLACE ";" " " command "${ARGN}")
    message(FATAL_ERROR "${command}\n${text}")
  endif()
endfunction()

file(REMOVE_RECURSE ${WORK})
set(home ${WORK}/home)
set(prefix ${home}/insitu)
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/installed)
file(MAKE_DIRECTORY ${home})
file(RENAME ${WORK}/installed ${prefix})
check_pages()
check_catalyst()

set(languages c cpp)
if(Fortran_COMPILER)
  list(APPEND languages fortran)
else()
  message(STATUS "Fortran is skipped: the module was not built")
endif()

find_program(PKG_CONFIG pkg-config)
if(PKG_CONFIG)
  check_pc(insitu "")
  check_pc_variables(insitu saturne)
  if(Fortran_COMPILER)
    check_pc(insitu-fortran insitu.mod)
    check_pc_variables(insitu fortran_modules fortran_library)
  endif()
  link_as_readme_says()
  make_as_fortran_guide_says()
else()
  message(STATUS "insitu.pc and examples/Makefile are skipped: pkg-config is not there")
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

# Beside the library, and found there: no other libinsitu-mpi is where the loader looks.
if(MPI_PROGRAM)
  run(${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${prefix}/${LIBDIR} OMPI_ALLOW_RUN_AS_ROOT=1
      OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 ${MPI_PROGRAM})
endif()

if(EXISTS ${prefix}/bin/insitu-replay)
  run(${prefix}/bin/insitu-replay --version)
endif()
file(REMOVE_RECURSE ${WORK})

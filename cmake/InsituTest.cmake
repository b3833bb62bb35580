# insitu_add_test(name SOURCES ... [LIBRARIES ...] [LABELS ...] [TIMEOUT seconds] [ARGS ...])
# A GoogleTest executable over the internal static library, registered with ctest once.
find_package(GTest REQUIRED)

# What is tested is compiled as users have it; tests themselves need little of that.
set(insitu_test_options $<$<CONFIG:Release>:-O1> "$<$<CONFIG:RelWithDebInfo>:SHELL:-O1 -g1>")

# Headers that nearly all tests include are compiled once, for all of them.
function(insitu_test_headers)
  if(TARGET insitu_test_headers)
    return()
  endif()
  # A program, as the tests are: libraries are compiled otherwise (-fPIC).
  file(CONFIGURE OUTPUT ${PROJECT_BINARY_DIR}/test_headers.cpp CONTENT "int main() {}\n")
  add_executable(insitu_test_headers ${PROJECT_BINARY_DIR}/test_headers.cpp)
  target_link_libraries(insitu_test_headers PRIVATE insitu_static insitu_flags GTest::gtest)
  target_compile_options(insitu_test_headers PRIVATE ${insitu_test_options})
  target_precompile_headers(insitu_test_headers PRIVATE
    <algorithm> <array> <atomic> <cmath> <filesystem> <fstream> <functional> <limits> <map> <memory> <optional> <set>
    <sstream> <string> <vector> <gtest/gtest.h>)
endfunction()

function(insitu_add_test name)
  cmake_parse_arguments(T "" "TIMEOUT" "SOURCES;LIBRARIES;LABELS;ARGS" ${ARGN})
  add_executable(${name} ${T_SOURCES})
  target_link_libraries(${name} PRIVATE insitu_static insitu_flags ${T_LIBRARIES} GTest::gtest
                                        GTest::gtest_main)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/libinsitu/src
                                             ${PROJECT_SOURCE_DIR}/tests)
  insitu_test_headers()
  target_precompile_headers(${name} REUSE_FROM insitu_test_headers)
  target_compile_options(${name} PRIVATE ${insitu_test_options})
  add_test(NAME ${name} COMMAND ${name} ${T_ARGS})
  if(NOT T_TIMEOUT)
    set(T_TIMEOUT 300)
  endif()
  if(INSITU_SANITIZE) # ThreadSanitizer slows code down ten times
    math(EXPR T_TIMEOUT "4 * ${T_TIMEOUT}")
  endif()
  set_tests_properties(${name} PROPERTIES TIMEOUT ${T_TIMEOUT} LABELS "${T_LABELS}")
endfunction()

# insitu_mpi_tests(test ...): tests that start MPI by themselves. It keeps memory to the end.
function(insitu_mpi_tests)
  set_tests_properties(${ARGN} PROPERTIES ENVIRONMENT "ASAN_OPTIONS=detect_leaks=0")
endfunction()

if(INSITU_HAVE_MPI)
  find_program(INSITU_MPIEXEC mpiexec)
else()
  unset(INSITU_MPIEXEC CACHE)
endif()
set(INSITU_TEST_PROCESSES 1 2 3 4 8 CACHE STRING "Numbers of processes that the miniapps are tested on")

# insitu_processes_test(name target processes [LABELS ...] [ARGS ...] [LAUNCHER ...]): a program on so many processes, each by way of
# the launcher if there is one; Open MPI asks for leave to run as root, and more processes than cores.
function(insitu_processes_test name target processes)
  cmake_parse_arguments(T "" "" "LABELS;ARGS;LAUNCHER" ${ARGN})
  if(NOT T_LABELS)
    set(T_LABELS api)
  endif()
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/${name}_run)
  file(MAKE_DIRECTORY ${folder})
  add_test(NAME ${name} COMMAND ${INSITU_MPIEXEC} -n ${processes} ${T_LAUNCHER} $<TARGET_FILE:${target}> ${T_ARGS} WORKING_DIRECTORY ${folder})
  set_tests_properties(${name} PROPERTIES TIMEOUT 120 LABELS "${T_LABELS}")
  insitu_mpi_tests(${name})
  set_property(TEST ${name} APPEND PROPERTY ENVIRONMENT OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1
               OMPI_MCA_rmaps_base_oversubscribe=1 "LD_LIBRARY_PATH=${PROJECT_BINARY_DIR}/lib:$ENV{LD_LIBRARY_PATH}")
endfunction()

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

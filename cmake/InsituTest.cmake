# insitu_add_test(name SOURCES ... [LIBRARIES ...] [LABELS ...] [TIMEOUT seconds] [ARGS ...])
# A GoogleTest executable over the internal static library, registered with ctest once.
find_package(GTest REQUIRED)

function(insitu_add_test name)
  cmake_parse_arguments(T "" "TIMEOUT" "SOURCES;LIBRARIES;LABELS;ARGS" ${ARGN})
  add_executable(${name} ${T_SOURCES})
  target_link_libraries(${name} PRIVATE insitu_static insitu_flags ${T_LIBRARIES} GTest::gtest
                                        GTest::gtest_main)
  target_include_directories(${name} PRIVATE ${PROJECT_SOURCE_DIR}/libinsitu/src
                                             ${PROJECT_SOURCE_DIR}/tests)
  target_compile_options(${name} PRIVATE $<$<CONFIG:Release>:-O1>) # what is tested is compiled as users have it
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

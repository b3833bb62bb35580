# Compiler settings that hold for every target of the project.
include(GNUInstallDirs)

if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release CACHE STRING "Build type" FORCE)
endif()
set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_C_STANDARD 99)
set(CMAKE_C_EXTENSIONS OFF)
set(CMAKE_POSITION_INDEPENDENT_CODE ON)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
set(CMAKE_RUNTIME_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/bin)
set(CMAKE_LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)
set(CMAKE_ARCHIVE_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/lib)

find_program(CCACHE_PROGRAM ccache)
mark_as_advanced(CCACHE_PROGRAM)
if(CCACHE_PROGRAM AND PROJECT_IS_TOP_LEVEL AND NOT CMAKE_CXX_COMPILER_LAUNCHER)
  set(CMAKE_C_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
  set(CMAKE_CXX_COMPILER_LAUNCHER ${CCACHE_PROGRAM})
endif()

# Warnings and arithmetic for our own C++ targets. Contraction is off everywhere: exact predicates and
# byte-identical results rest on each operation being rounded once.
add_library(insitu_flags INTERFACE)
target_compile_options(insitu_flags INTERFACE
  $<$<COMPILE_LANGUAGE:C,CXX>:-Wall -Wextra -Wpedantic -Wshadow -ffp-contract=off>
  # GCC 12 sees overlapping copies in string concatenation and uninitialised reads in loops over a shape's vertex count that never happen.
  $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-maybe-uninitialized -Wno-restrict>
  $<$<AND:$<BOOL:${INSITU_WERROR}>,$<COMPILE_LANGUAGE:C,CXX>>:-Werror>)
# Highway compiles per-target code for three x86 levels and the baseline: each one more costs compile time
# and gains little here.
target_compile_definitions(insitu_flags INTERFACE
  "$<$<COMPILE_LANGUAGE:CXX>:HWY_DISABLED_TARGETS=(HWY_SSSE3|HWY_SSE4|HWY_AVX3_DL)>")
if(INSITU_SANITIZE)
  add_compile_options($<$<COMPILE_LANGUAGE:C,CXX>:-fsanitize=${INSITU_SANITIZE}>
                      $<$<COMPILE_LANGUAGE:C,CXX>:-fno-omit-frame-pointer>
                      $<$<COMPILE_LANGUAGE:C,CXX>:-fno-sanitize-recover=all>)
  add_link_options(-fsanitize=${INSITU_SANITIZE})
endif()

# Marks sources whose SIMD kernels are inlined whole, which live on temporaries: GCC 12 compiles the
# poisoning of each temporary's scope for ten minutes. All other checks of the sanitizers stay.
function(insitu_inlined_kernels target)
  if(INSITU_SANITIZE MATCHES address AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    set_source_files_properties(${ARGN} TARGET_DIRECTORY ${target}
                                PROPERTIES COMPILE_OPTIONS -fno-sanitize-address-use-after-scope)
  endif()
endfunction()

# insitu_unity(target most [apart ...]): with INSITU_UNITY, compiles the target's C++ files in groups of one module, at
# most so many in each, which takes less than half of the time, as headers and templates of the standard library are
# worked through once a group. Files that Highway compiles once for each SIMD target stay alone, and so do the named
# ones, whose local names others of their module have too or which instantiate long templates by themselves.
function(insitu_unity target most)
  if(NOT INSITU_UNITY)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  get_target_property(home ${target} SOURCE_DIR)
  foreach(source ${sources})
    if(NOT source MATCHES "\\.cpp$")
      continue()
    endif()
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${home} OUTPUT_VARIABLE file)
    get_filename_component(name ${file} NAME_WE)
    file(STRINGS ${file} once_a_target REGEX "foreach_target" LIMIT_COUNT 1)
    get_filename_component(folder ${file} DIRECTORY)
    file(RELATIVE_PATH folder ${PROJECT_SOURCE_DIR} ${folder})
    string(REGEX REPLACE "^libinsitu/src/(accel/(embree|faces|morton)|[^/]+).*" "\\1" folder ${folder}) # rooms of a module together
    if(once_a_target OR name IN_LIST ARGN)
      set_source_files_properties(${file} TARGET_DIRECTORY ${target} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
      continue()
    endif()
    list(APPEND groups_${folder} x)
    list(LENGTH groups_${folder} count)
    math(EXPR group "${count} / ${most}")
    string(MAKE_C_IDENTIFIER "${folder}_${group}" name)
    set_source_files_properties(${file} TARGET_DIRECTORY ${target} PROPERTIES UNITY_GROUP ${name})
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
  # GCC takes the file that includes a group's files for a header's user and warns of their local types.
  # Its limit on the growth by inlining counts the whole group: without a higher one, frames took 1.1 of their time.
  target_compile_options(${target} PRIVATE
    "$<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-subobject-linkage;--param=large-unit-insns=1000000>")
endfunction()

# Headers of another OptiX, or none, end a configuration with the reason.
#   cmake -DMODULE=<cmake/InsituOptix.cmake> -DFOLDER=<scratch> -P optix_version.cmake
if(DEFINED ROOT) # one check, in a process of its own
  include(${MODULE})
  insitu_check_optix(${ROOT})
  return()
endif()

# header: what optix.h has; `none`: no such file. wanted: in the message; empty: it is accepted.
function(expect name header wanted)
  set(root ${FOLDER}/${name})
  file(REMOVE_RECURSE ${root})
  file(MAKE_DIRECTORY ${root}/include)
  if(NOT header STREQUAL none)
    file(WRITE ${root}/include/optix.h "// OptiX\n${header}\n")
  endif()
  execute_process(COMMAND ${CMAKE_COMMAND} -DMODULE=${MODULE} -DROOT=${root} -P
                          ${CMAKE_CURRENT_FUNCTION_LIST_FILE}
                  RESULT_VARIABLE status ERROR_VARIABLE text OUTPUT_QUIET)
  string(REGEX REPLACE "[ \n]+" " " text "${text}") # messages are broken into lines
  if(wanted STREQUAL "")
    if(NOT status EQUAL 0)
      message(SEND_ERROR "${name}: refused: ${text}")
    endif()
  elseif(status EQUAL 0 OR NOT text MATCHES "${wanted}")
    message(SEND_ERROR "${name}: '${wanted}' is not in '${text}'")
  endif()
endfunction()

expect(absent none "no include/optix.h in INSITU_OPTIX_ROOT")
expect(old "#define OPTIX_VERSION 70600" "headers of OptiX 7.6; 7.7 or later is needed")
expect(unknown "#define OPTIX_H" "does not tell OPTIX_VERSION")
expect(oldest "#define OPTIX_VERSION 70700" "")
expect(newer "#  define X\n#define OPTIX_VERSION 90000" "")

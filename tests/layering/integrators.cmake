# Frames' integrators are instantiated for few sets of effects: at most a dozen times a family, and
# the code of a family stays below a ceiling, which keeps its build time bounded as well (see
# build_time.sh, which measures that). Counted are symbols of all objects, however sources are
# grouped: what the compiler put wholly in line has none, and its code counts where it is in line.
#
# cmake -DNM=nm -DOBJECTS=<a;b;...> -P integrators.cmake

set(most_instantiations 12)
# family # classes # most kilobytes of their methods' code: about twice what it was when this was set; of surfaces also what several processes share
set(families
  "ray marching#VolumeMarcher Preintegration VolumeShadow#140"
  "path tracing#PathTracer PathWave Medium PathLights#140"
  "isosurfaces#IsosurfaceTracer CellRoots Surfaces Shader#132"
  "particles#Mover#320")

foreach(family IN LISTS families)
  string(REPLACE "#" ";" parts "${family}")
  list(GET parts 0 name)
  list(GET parts 1 classes)
  list(GET parts 2 ceiling)
  string(REPLACE " " "|" either "${classes}")
  string(REPLACE " " ";" classes "${classes}")

  execute_process(COMMAND ${NM} -C -S --defined-only ${OBJECTS}
                  COMMAND grep -E "::(${either})(<|::)" OUTPUT_VARIABLE symbols
                  RESULTS_VARIABLE failed)
  if(NOT failed STREQUAL "0;0")
    message(FATAL_ERROR "${name}: ${NM} failed, or no symbol of ${classes}: ${failed}")
  endif()
  set(text 0)
  string(REGEX MATCHALL "\n[0-9a-f]+ [0-9a-f]+ [tTwWuV] [^\n]*::(${either})(<[^\n()]*>)?::[^\n]*" lines
         "\n${symbols}")
  list(REMOVE_DUPLICATES lines)
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "^\n[0-9a-f]+ ([0-9a-f]+) .*" "0x\\1" bytes "${line}")
    math(EXPR text "${text} + ${bytes}")
  endforeach()
  math(EXPR kilobytes "${text} / 1000")
  if(kilobytes EQUAL 0 OR kilobytes GREATER ceiling)
    message(SEND_ERROR "${name}: ${kilobytes} kB of code, ${ceiling} allowed")
  endif()

  string(REGEX REPLACE "[][;]" "_" symbols "${symbols}")
  foreach(class IN LISTS classes)
    # A class of its own, or a template's: "VolumeMarcher::", "Mover<insitu::advect::DriftVelocity>::".
    string(REGEX MATCHALL "::${class}(<[^\n()]*>)?::[A-Za-z_~]+(<[^\n(]*>)?\\(" found "${symbols}")
    list(REMOVE_DUPLICATES found)
    set(of_class 0)
    set(kinds "")
    set(methods "")
    foreach(symbol IN LISTS found)
      if(symbol MATCHES "^::${class}(<.*>)::[A-Za-z_~]+")
        string(REGEX REPLACE "::[A-Za-z_~]+(<[^<>]*>)?\\($" "" kind "${symbol}")
        list(APPEND kinds "${kind}")
      else()
        string(REGEX REPLACE "(<.*)?\\($" "" method "${symbol}")
        list(APPEND methods "${method}")
      endif()
    endforeach()
    set(most 1)
    list(REMOVE_DUPLICATES kinds)
    list(LENGTH kinds of_class)
    if(of_class GREATER most)
      set(most ${of_class})
    endif()
    set(distinct ${methods})
    list(REMOVE_DUPLICATES distinct)
    foreach(method IN LISTS distinct)
      set(same ${methods})
      list(FILTER same INCLUDE REGEX "^${method}$")
      list(LENGTH same count)
      if(count GREATER most)
        set(most ${count})
      endif()
    endforeach()
    if(found STREQUAL "")
      message(SEND_ERROR "${name}: no symbol of ${class}")
    endif()
    message(STATUS "${name}: ${class} ${most} times of ${most_instantiations}")
    if(most GREATER most_instantiations)
      message(SEND_ERROR "${name}: ${class} is instantiated ${most} times")
    endif()
  endforeach()
  message(STATUS "${name}: ${kilobytes} kB of ${ceiling}")
endforeach()

# SPDX-License-Identifier: Apache-2.0
# spheretree_unity(TARGET [ALONE source...] [GROUP_BY_NAME]): compiles the sources of each folder of the target as one
# translation unit, because most of the time of a compiler goes into the same headers and templates again and again.
# Sources named after ALONE stay on their own, as do sources with compile options of their own. Without
# SPHERETREE_UNITY every source is compiled alone; .ci/run does so once, so that each source includes what it uses.
# SPHERETREE_ALONE names sources by a regular expression that are compiled alone, too: who works on a folder waits for
# one source at a time, and for the rest of the project as quickly as ever.
option(SPHERETREE_UNITY "Compile the sources of a folder as one translation unit" ON)
set(SPHERETREE_ALONE "" CACHE STRING "Regular expression of the sources (paths in the checkout) that are compiled alone")

function(spheretree_unity target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "ALONE")
  if(NOT SPHERETREE_UNITY)
    return()
  endif()
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    get_filename_component(folder ${source} DIRECTORY)
    string(MAKE_C_IDENTIFIER "${target}_${folder}" group)
    set_source_files_properties(${source} PROPERTIES UNITY_GROUP ${group})
    get_filename_component(path ${source} ABSOLUTE)
    file(RELATIVE_PATH path ${PROJECT_SOURCE_DIR} ${path})
    if(SPHERETREE_ALONE AND path MATCHES "${SPHERETREE_ALONE}")
      set_source_files_properties(${source} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
    endif()
  endforeach()
  if(arg_ALONE)
    set_source_files_properties(${arg_ALONE} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
  endif()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_MODE GROUP)
endfunction()

# SPDX-License-Identifier: Apache-2.0
# Installs the build BUILD under WORK/prefix, configures and builds the project CONSUMER against it, runs its programs,
# and asks the installed `spheretree` to validate the tree that came out. The examples of DOCS/runtime.md are part of
# the project; those in C are compiled once more with what pkg-config says, and nothing else.
cmake_minimum_required(VERSION 3.25)
set(prefix ${WORK}/prefix)
set(examples ${WORK}/examples)
file(REMOVE_RECURSE ${prefix} ${WORK}/consumer ${examples})

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  message("${output}")
  if(NOT code EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "exit code ${code}: ${command}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
run(${PYTHON} ${CONSUMER}/../doc_examples.py ${DOCS}/runtime.md ${examples})
run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK}/consumer -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_BUILD_TYPE=Release
  -DCMAKE_CXX_COMPILER=${COMPILER} -DEXAMPLES=${examples} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/build_and_read ${WORK}/consumer/cube.stree)
run(${WORK}/consumer/read_only ${WORK}/consumer/cube.stree)
run(${prefix}/bin/spheretree inspect ${WORK}/consumer/cube.stree)

# A component that there is not: the reason names it, and what there is.
execute_process(COMMAND ${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK}/consumer_wrong -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${prefix} -DWANTED=runtim
  -DCMAKE_CXX_COMPILER=${COMPILER} RESULT_VARIABLE code OUTPUT_QUIET ERROR_VARIABLE output)
string(REGEX REPLACE "[ \n]+" " " output "${output}")
if(code EQUAL 0 OR NOT output MATCHES "no component \"runtim\"[^.]*\\. There are: core, runtime,[^.]*, builder\\.")
  message(FATAL_ERROR "find_package of an unknown component: ${output}")
endif()

# The examples of the page, as a reader runs them: in a folder with its trees and its scene.
set(cube ${WORK}/consumer/cube.stree)
file(COPY_FILE ${cube} ${examples}/probe.stree)
file(COPY_FILE ${cube} ${examples}/tooth.stree)
file(WRITE ${examples}/scene.json [=[{"schema": "spheretree.scene/1", "tool": {"name": "probe", "tree": "probe.stree"},
  "bodies": [{"name": "jaw", "hinge": {"point_mm": [0, 0, 0], "axis": [1, 0, 0], "angle_deg": [[0, 0]]}}],
  "objects": [{"name": "tooth", "tree": "tooth.stree", "body": "jaw", "friction": 0.2}]}]=])
function(run_example program)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${libdir} ${program} WORKING_DIRECTORY ${examples}
    RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  message("${output}")
  # The tool, a cube of 10 mm, comes down on another one: the last line has the force of the spring.
  if(NOT code EQUAL 0 OR NOT output MATCHES "force [0-9.-]+ [0-9.-]+ [1-9][0-9.]* N\n$")
    message(FATAL_ERROR "${program}: exit code ${code}")
  endif()
endfunction()
foreach(name IN ITEMS first_step scene_in_cpp)
  run_example(${WORK}/consumer/${name})
endforeach()
file(GLOB_RECURSE pc ${prefix}/*/spheretree-runtime.pc)
cmake_path(GET pc PARENT_PATH pc)
cmake_path(GET pc PARENT_PATH libdir)
foreach(example IN ITEMS first_step_in_c:runtime scene_in_c:scene)
  string(REPLACE ":" ";" example ${example})
  list(GET example 0 name)
  list(GET example 1 package)
  execute_process(COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${pc} ${PKG_CONFIG} --cflags --libs spheretree-${package}
    OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
  separate_arguments(flags UNIX_COMMAND "${flags}")
  run(${C_COMPILER} -std=c99 -Wall -Wextra -Werror -pedantic ${examples}/${name}.c ${flags} -o ${examples}/${name})
  run_example(${examples}/${name})
endforeach()

# The servo loop in C.
execute_process(COMMAND ${CMAKE_COMMAND} -E env PKG_CONFIG_PATH=${pc} ${PKG_CONFIG} --cflags --libs spheretree-servo spheretree-runtime
  OUTPUT_VARIABLE flags OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
separate_arguments(flags UNIX_COMMAND "${flags}")
run(${C_COMPILER} -std=c99 -Wall -Wextra -Werror -pedantic ${CONSUMER}/../../servo/servo_in_c.c ${flags} -o ${examples}/servo_in_c)
run(${CMAKE_COMMAND} -E env LD_LIBRARY_PATH=${libdir} ${examples}/servo_in_c)

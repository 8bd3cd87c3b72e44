# SPDX-License-Identifier: Apache-2.0
# Installs the build BUILD under WORK/prefix, configures and builds the project CONSUMER against it, runs its programs,
# and asks the installed `spheretree` to validate the tree that came out.
cmake_minimum_required(VERSION 3.25)
set(prefix ${WORK}/prefix)
file(REMOVE_RECURSE ${prefix} ${WORK}/consumer)

function(run)
  execute_process(COMMAND ${ARGN} RESULT_VARIABLE code OUTPUT_VARIABLE output ERROR_VARIABLE output)
  message("${output}")
  if(NOT code EQUAL 0)
    list(JOIN ARGN " " command)
    message(FATAL_ERROR "exit code ${code}: ${command}")
  endif()
endfunction()

run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${prefix})
run(${CMAKE_COMMAND} -S ${CONSUMER} -B ${WORK}/consumer -G ${GENERATOR} -DCMAKE_PREFIX_PATH=${prefix} -DCMAKE_BUILD_TYPE=Release
  -DCMAKE_CXX_COMPILER=${COMPILER} -DCMAKE_CXX_COMPILER_LAUNCHER=${LAUNCHER})
run(${CMAKE_COMMAND} --build ${WORK}/consumer)
run(${WORK}/consumer/build_and_read ${WORK}/consumer/cube.stree)
run(${WORK}/consumer/read_only ${WORK}/consumer/cube.stree)
run(${prefix}/bin/spheretree inspect ${WORK}/consumer/cube.stree)

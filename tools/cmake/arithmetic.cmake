# SPDX-License-Identifier: Apache-2.0
# Compiles and runs a program with the options that the libraries get. Proofs and equal bytes rest on arithmetic as
# IEEE 754 defines it: a build with options or a compiler that calculate otherwise is refused here.
get_target_property(arithmetic_options spheretree_flags INTERFACE_COMPILE_OPTIONS)
string(GENEX_STRIP "${arithmetic_options}" arithmetic_options)
if(CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  list(APPEND arithmetic_options -fno-tree-slp-vectorize)
endif()
set(CMAKE_TRY_COMPILE_CONFIGURATION ${CMAKE_BUILD_TYPE})
set(arithmetic_key "${CMAKE_CXX_COMPILER} ${CMAKE_CXX_COMPILER_VERSION} ${CMAKE_CXX_FLAGS} ${CMAKE_BUILD_TYPE} ${arithmetic_options}")
if(CMAKE_CROSSCOMPILING AND NOT CMAKE_CROSSCOMPILING_EMULATOR)
  message(STATUS "Arithmetic is not checked: programs for this machine do not run here. core_test checks it there.")
elseif(NOT SPHERETREE_ARITHMETIC_CHECKED STREQUAL arithmetic_key)
  try_run(arithmetic_run arithmetic_compiled ${CMAKE_BINARY_DIR}/arithmetic ${CMAKE_CURRENT_LIST_DIR}/arithmetic_check.cpp
    CMAKE_FLAGS -DINCLUDE_DIRECTORIES=${PROJECT_SOURCE_DIR}/libruntime/core/include$<SEMICOLON>${EIGEN3_INCLUDE_DIRS}
    COMPILE_DEFINITIONS ${arithmetic_options}
    COMPILE_OUTPUT_VARIABLE arithmetic_errors RUN_OUTPUT_VARIABLE arithmetic_output)
  if(NOT arithmetic_compiled)
    message(FATAL_ERROR "tools/cmake/arithmetic_check.cpp does not compile:\n${arithmetic_errors}")
  elseif(NOT arithmetic_run STREQUAL "0")
    message(FATAL_ERROR "This compiler, with these options, does not calculate as the proofs need it:\n${arithmetic_output}"
      "CMAKE_CXX_FLAGS is '${CMAKE_CXX_FLAGS}', CMAKE_BUILD_TYPE '${CMAKE_BUILD_TYPE}'.")
  endif()
  set(SPHERETREE_ARITHMETIC_CHECKED "${arithmetic_key}" CACHE INTERNAL "Compiler and options whose arithmetic is right")
endif()

# SPDX-License-Identifier: GPL-3.0-or-later
# Runs an independent program that measures what is felt (feel_figures.py), where its source and its packages are.
# Limits leave room above the figures of docs/stability.md, which are those of more strokes.
# That of the system: its packages are Debian's.
find_program(SPHERETREE_SYSTEM_PYTHON python3 PATHS /usr/bin NO_DEFAULT_PATH)
execute_process(COMMAND ${SPHERETREE_SYSTEM_PYTHON} -c "import numpy, scipy.optimize" RESULT_VARIABLE no_numpy OUTPUT_QUIET ERROR_QUIET)
if(EXISTS "${SPHERETREE_SHARED_DIR}/feel/feel.py" AND no_numpy EQUAL 0)
  function(add_feel_test name mesh)
    cmake_parse_arguments(arg "" "" "LIMITS;OPTIONS" ${ARGN})
    add_test(NAME feel.${name} COMMAND ${SPHERETREE_SYSTEM_PYTHON} ${CMAKE_CURRENT_SOURCE_DIR}/pipeline/feel_figures.py
      ${SPHERETREE_SHARED_DIR}/feel/feel.py $<TARGET_FILE:spheretree> $<TARGET_FILE:haptic-player> ${SPHERETREE_SHARED_DIR}/meshes/${mesh}
      ${CMAKE_CURRENT_BINARY_DIR}/feel_${name} ${arg_LIMITS} -- --strokes 4 ${arg_OPTIONS})
    set_tests_properties(feel.${name} PROPERTIES LABELS pipeline)
  endfunction()
  # A smooth body of 11,712 triangles, made from one of 2,928 by subdivision: the truth is the limit of the subdivision.
  add_feel_test(spot bench/organic_spot.obj OPTIONS --smooth LIMITS angle_median=2 angle_p99=6 inside=0.02 outside=0.015 jump_max=0.05)
  # Flat faces and sharp edges; what is not exact are its round faces, which the mesh has as facets.
  add_feel_test(fandisk bench/cad_fandisk.obj LIMITS angle_median=0.05 inside=0.02 outside=0.03 jump_median=0.01)
endif()

# SPDX-License-Identifier: Apache-2.0
# Trees of the sample meshes, from mesh file to verdict. The fixture `judge` is in judge.cmake.
find_package(Python3 COMPONENTS Interpreter)
if(Python3_FOUND)
  foreach(builder IN ITEMS cover merge expand)
    add_test(NAME pipeline.judged_trees.${builder} COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/judged_trees.py
      ${CMAKE_CURRENT_BINARY_DIR}/judge/judge $<TARGET_FILE:spheretree> $<TARGET_FILE:make_samples>
      ${CMAKE_CURRENT_BINARY_DIR}/judged_trees_${builder} ${builder})
    set_tests_properties(pipeline.judged_trees.${builder} PROPERTIES LABELS pipeline FIXTURES_REQUIRED judge TIMEOUT 900 SKIP_RETURN_CODE 77)
  endforeach()
endif()

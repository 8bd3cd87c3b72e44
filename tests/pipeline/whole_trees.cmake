# SPDX-License-Identifier: Apache-2.0
# Trees of whole meshes, from mesh file to verdict. The fixture `judge` is in judge.cmake.
find_package(Python3 COMPONENTS Interpreter)
if(Python3_FOUND)
  add_test(NAME pipeline.judged_trees COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/judged_trees.py
    ${CMAKE_CURRENT_BINARY_DIR}/judge/judge $<TARGET_FILE:spheretree> $<TARGET_FILE:make_samples> ${CMAKE_CURRENT_BINARY_DIR}/judged_trees)
  set_tests_properties(pipeline.judged_trees PROPERTIES LABELS pipeline FIXTURES_REQUIRED judge SKIP_RETURN_CODE 77)
  # Published methods against the program of their authors, judged for bare surface as well; the whole table:
  # tools/doc_tables.py.
  add_test(NAME pipeline.toolkit_comparison COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/toolkit_comparison.py
    ${CMAKE_CURRENT_BINARY_DIR}/judge/judge $<TARGET_FILE:spheretree> ${SPHERETREE_SHARED_DIR}/meshes/toolkit
    ${CMAKE_CURRENT_BINARY_DIR}/toolkit_comparison --builders expand,merge,spawn --meshes plate)
  set_tests_properties(pipeline.toolkit_comparison PROPERTIES LABELS pipeline FIXTURES_REQUIRED judge SKIP_RETURN_CODE 77)
  add_executable(write_golden_trees pipeline/write_golden_trees.cpp)
  target_link_libraries(write_golden_trees PRIVATE spheretree::builder spheretree::formats spheretree_glue_flags)
  # The same bytes whatever the compiler, its options and the number of threads.
  add_test(NAME pipeline.golden_trees COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/golden_trees.py ${CMAKE_BINARY_DIR})
  set_tests_properties(pipeline.golden_trees PROPERTIES LABELS pipeline)
  # Meshes of others, sound or not; SPHERETREE_LONG=1 takes all of them.
  add_test(NAME pipeline.mesh_sweep COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/mesh_sweep.py $<TARGET_FILE:spheretree>
    ${SPHERETREE_SHARED_DIR}/meshes ${CMAKE_CURRENT_BINARY_DIR}/mesh_sweep)
  set_tests_properties(pipeline.mesh_sweep PROPERTIES LABELS pipeline SKIP_RETURN_CODE 77 COST 10)
endif()

# SPDX-License-Identifier: Apache-2.0
# spheretree batch under what happens to long jobs: kills, job arrays, meshes as they come.
find_package(Python3 COMPONENTS Interpreter)
if(Python3_FOUND)
  add_test(NAME pipeline.batch_recovery COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/batch_recovery.py
    $<TARGET_FILE:spheretree> $<TARGET_FILE:make_samples> ${CMAKE_CURRENT_BINARY_DIR}/batch_recovery)
  set_tests_properties(pipeline.batch_recovery PROPERTIES LABELS pipeline TIMEOUT 3600)
endif()
foreach(scheduler IN ITEMS parallel slurm)
  add_test(NAME pipeline.job_arrays.${scheduler} COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/job_arrays.sh
    ${scheduler} $<TARGET_FILE:spheretree> ${CMAKE_SOURCE_DIR}/docs/batch.md)
  set_tests_properties(pipeline.job_arrays.${scheduler} PROPERTIES LABELS pipeline TIMEOUT 600 SKIP_RETURN_CODE 77)
endforeach()

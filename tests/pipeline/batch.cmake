# SPDX-License-Identifier: Apache-2.0
# spheretree batch under what happens to long jobs: kills, job arrays, meshes as they come.
find_package(Python3 COMPONENTS Interpreter)
if(Python3_FOUND)
  add_test(NAME pipeline.batch_recovery COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/batch_recovery.py
    $<TARGET_FILE:spheretree> $<TARGET_FILE:make_samples> ${CMAKE_CURRENT_BINARY_DIR}/batch_recovery)
  set_tests_properties(pipeline.batch_recovery PROPERTIES LABELS pipeline COST 10)
  add_test(NAME pipeline.cohort_recovery COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/cohort_recovery.py
    $<TARGET_FILE:spheretree>)
  set_tests_properties(pipeline.cohort_recovery PROPERTIES LABELS pipeline SKIP_RETURN_CODE 77 COST 10)
  add_test(NAME pipeline.cohort_shares COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/cohort_shares.py $<TARGET_FILE:spheretree>)
  set_tests_properties(pipeline.cohort_shares PROPERTIES LABELS pipeline)
  add_test(NAME pipeline.dental_scene COMMAND ${Python3_EXECUTABLE} ${CMAKE_CURRENT_LIST_DIR}/dental_scene.py $<TARGET_FILE:spheretree>
    $<TARGET_FILE:make_samples> $<TARGET_FILE:haptic-player> ${SPHERETREE_SHARED_DIR}/meshes ${CMAKE_CURRENT_BINARY_DIR}/dental_scene)
  set_tests_properties(pipeline.dental_scene PROPERTIES LABELS pipeline SKIP_RETURN_CODE 77 COST 10)
endif()
foreach(scheduler IN ITEMS slurm snakemake)
  add_test(NAME pipeline.cohort_jobs.${scheduler} COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/job_arrays.sh
    ${scheduler} $<TARGET_FILE:spheretree> ${CMAKE_SOURCE_DIR}/docs/cohorts.md)
  set_tests_properties(pipeline.cohort_jobs.${scheduler} PROPERTIES LABELS pipeline SKIP_RETURN_CODE 77 COST 10)
endforeach()
foreach(scheduler IN ITEMS parallel slurm)
  add_test(NAME pipeline.job_arrays.${scheduler} COMMAND bash ${CMAKE_CURRENT_LIST_DIR}/job_arrays.sh
    ${scheduler} $<TARGET_FILE:spheretree> ${CMAKE_SOURCE_DIR}/docs/batch.md)
  set_tests_properties(pipeline.job_arrays.${scheduler} PROPERTIES LABELS pipeline SKIP_RETURN_CODE 77 COST 10)
endforeach()

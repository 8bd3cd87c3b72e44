# SPDX-License-Identifier: Apache-2.0
# Builds trees of the sample meshes and of some of the shared ones, and measures them.
add_executable(cover_measures_test pipeline/cover_measures_test.cpp)
target_include_directories(cover_measures_test PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
target_compile_definitions(cover_measures_test PRIVATE SPHERETREE_SHARED_DIR="${SPHERETREE_SHARED_DIR}")
target_link_libraries(cover_measures_test PRIVATE sample_meshes spheretree::builder_internal spheretree::formats spheretree_glue_flags GTest::gtest_main)
gtest_discover_tests(cover_measures_test DISCOVERY_MODE PRE_TEST PROPERTIES LABELS pipeline)

foreach(test IN ITEMS every_tolerance_test sensitivity_test tolerance_test)
  add_executable(${test} pipeline/${test}.cpp)
  target_include_directories(${test} PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_compile_definitions(${test} PRIVATE SPHERETREE_SHARED_DIR="${SPHERETREE_SHARED_DIR}")
  target_link_libraries(${test} PRIVATE sample_meshes spheretree::builder_internal spheretree::formats spheretree_glue_flags GTest::gtest_main)
  gtest_discover_tests(${test} DISCOVERY_MODE PRE_TEST PROPERTIES LABELS pipeline)
endforeach()

# SPDX-License-Identifier: Apache-2.0
# Compares `spheretree evaluate` with an independent program, which is configured and built in a folder of its own by
# the tests' first step; where its source is missing, the comparison skips itself.
add_executable(judge_agreement_test pipeline/judge_agreement_test.cpp)
target_include_directories(judge_agreement_test PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
set(judge_build ${CMAKE_CURRENT_BINARY_DIR}/judge)
target_compile_definitions(judge_agreement_test PRIVATE JUDGE_PROGRAM="${judge_build}/judge" SPHERETREE_SHARED_DIR="${SPHERETREE_SHARED_DIR}")
target_link_libraries(judge_agreement_test PRIVATE
  spheretree::builder_internal spheretree::formats nlohmann_json::nlohmann_json spheretree_glue_flags GTest::gtest_main)
if(EXISTS "${SPHERETREE_SHARED_DIR}/judge/CMakeLists.txt")
  add_test(NAME judge_configure
    COMMAND ${CMAKE_COMMAND} -S ${SPHERETREE_SHARED_DIR}/judge -B ${judge_build} -DBUILD_TESTING=OFF -DCMAKE_BUILD_TYPE=Release)
  add_test(NAME judge_build COMMAND ${CMAKE_COMMAND} --build ${judge_build} --target judge)
  set_tests_properties(judge_configure PROPERTIES FIXTURES_SETUP judge_configured LABELS pipeline COST 10)
  set_tests_properties(judge_build PROPERTIES FIXTURES_SETUP judge FIXTURES_REQUIRED judge_configured LABELS pipeline COST 10)
endif()
gtest_discover_tests(judge_agreement_test DISCOVERY_MODE PRE_TEST PROPERTIES LABELS pipeline FIXTURES_REQUIRED judge)

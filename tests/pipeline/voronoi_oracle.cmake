# SPDX-License-Identifier: GPL-3.0-or-later
# Our Voronoi vertices against those of TetGen, which runs as a program of its own (tools/voronoi_oracle); without
# TetGen there is no such test.
if(TARGET voronoi_oracle)
  add_executable(voronoi_oracle_test pipeline/voronoi_oracle_test.cpp)
  target_include_directories(voronoi_oracle_test PRIVATE ${CMAKE_CURRENT_SOURCE_DIR})
  target_compile_definitions(voronoi_oracle_test PRIVATE VORONOI_ORACLE="$<TARGET_FILE:voronoi_oracle>")
  target_link_libraries(voronoi_oracle_test PRIVATE spheretree::builder_internal spheretree_glue_flags GTest::gtest_main)
  add_dependencies(voronoi_oracle_test voronoi_oracle)
  gtest_discover_tests(voronoi_oracle_test DISCOVERY_MODE PRE_TEST PROPERTIES LABELS pipeline)
endif()

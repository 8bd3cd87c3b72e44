// SPDX-License-Identifier: Apache-2.0
// A description compiled to a scene, for tests in which that must succeed.
#pragma once

#include <gtest/gtest.h>

#include <string>

#include "spheretree/runtime/scene.h"

namespace spheretree::test {

inline runtime::Scene compiled(const runtime::SceneDescription& description) {
  runtime::Scene scene;
  std::string fault;
  EXPECT_TRUE(runtime::compileScene(description, scene, fault)) << fault;
  return scene;
}

}  // namespace spheretree::test

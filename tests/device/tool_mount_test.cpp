// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/tool_mount.h"

#include <gtest/gtest.h>

#include "support/random.h"

namespace spheretree::device {
namespace {

TEST(ToolMount, AForceAtTheTipIsATorqueAtTheHandle) {
  for (const double arm : {60., 100.}) {
    ToolMount mount;
    mount.reference_in_handle.position = {0, 0, -arm};  // the tool points away from the user
    const Wrench on_handle = wrenchOnHandle(mount, {}, {{1, 0, 0}, {0, 0, 0}});
    EXPECT_NEAR(on_handle.torque.y(), -arm, 1e-12);
    EXPECT_NEAR(on_handle.force.x(), 1, 1e-15);
  }
}

/// Virtual work: what the hand does on the handle is what the tool does in the world, for any small motion.
TEST(ToolMount, NoPowerIsLostBetweenHandleAndTool) {
  spheretree::test::Random random(5);
  for (int n = 0; n < 1000; ++n) {
    const ToolMount mount{{random.inCube(300), rotationOf(random.inCube(3))}, {random.inCube(100), rotationOf(random.inCube(3))}};
    const Configuration handle{random.inCube(300), rotationOf(random.inCube(3))};
    const Wrench wrench{random.inCube(5), random.inCube(100)};
    const double small = 1e-6;
    const Displacement motion{small * random.inCube(1), small * random.inCube(0.1)};
    const Displacement of_tool = displacementBetween(toolInWorld(mount, handle), toolInWorld(mount, moved(handle, motion)));
    const Wrench felt = wrenchOnHandle(mount, handle, wrench);
    const double at_tool = wrench.force.dot(of_tool.translation) + wrench.torque.dot(of_tool.rotation);
    const double at_handle = felt.force.dot(motion.translation) + felt.torque.dot(motion.rotation);
    ASSERT_NEAR(at_tool, at_handle, 1e-9 * (1 + std::abs(at_tool)));
    ASSERT_NEAR(felt.force.norm(), wrench.force.norm(), 1e-12);
  }
}

TEST(ToolMount, TheHandleOfAToolIsTheOneThatHoldsIt) {
  spheretree::test::Random random(6);
  for (int n = 0; n < 1000; ++n) {
    const ToolMount mount{{random.inCube(300), rotationOf(random.inCube(3))}, {random.inCube(100), rotationOf(random.inCube(3))}};
    const Configuration tool{random.inCube(300), rotationOf(random.inCube(3))};
    const Displacement off = displacementBetween(tool, toolInWorld(mount, handleOf(mount, tool)));
    ASSERT_LT(off.translation.norm(), 1e-11);
    ASSERT_LT(off.rotation.norm(), 1e-7);  // a rotation vector of less is 0 but for rounding
  }
}

}  // namespace
}  // namespace spheretree::device

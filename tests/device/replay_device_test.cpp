// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/replay_device.h"

#include <gtest/gtest.h>

#include <chrono>
#include <limits>
#include <thread>

#include "scripted_renderer.h"

namespace spheretree::device {
namespace {

using test::Answer, test::somePoses;

TEST(ReplayDevice, GivesEveryPoseOnceAndEnds) {
  const std::vector<Configuration> poses = somePoses(5);
  ReplayDevice device(poses);
  Answer renderer;
  for (int run = 0; run < 2; ++run) {  // a second run begins at the first pose again
    renderer.seen.clear();
    device.start(renderer, {}, Clock::Stepped);
    int steps = 0;
    while (device.step()) ++steps;
    EXPECT_EQ(steps, 5);
    EXPECT_EQ(device.status().phase, Phase::Ended);
    EXPECT_EQ(device.status().ticks, 5u);
    ASSERT_EQ(renderer.seen.size(), 5u);
    for (std::size_t n = 0; n < 5; ++n) {
      EXPECT_EQ(renderer.seen[n].handle.position, poses[n].position);
      EXPECT_EQ(renderer.seen[n].handle.orientation.coeffs(), poses[n].orientation.coeffs());
      EXPECT_EQ(renderer.seen[n].tick, n);
      EXPECT_DOUBLE_EQ(renderer.seen[n].time, static_cast<double>(n) * 1e-3);
    }
    device.stop();
    EXPECT_EQ(device.status().phase, Phase::Ended) << "stop() keeps the first reason";
  }
}

TEST(ReplayDevice, NeedsAPose) {
  try {
    ReplayDevice device({});
    FAIL() << "it was accepted";
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.fault, DeviceFault::Refused);
    EXPECT_NE(std::string(error.what()).find("no pose"), std::string::npos) << error.what();
  }
}

/// The content of a recording is replayed, even if it is invalid; the safety rules check the wrench.
TEST(ReplayDevice, PassesOnInvalidPoses) {
  std::vector<Configuration> poses = somePoses(4);
  poses[1].position.x() = std::numeric_limits<double>::quiet_NaN();
  poses[2].orientation = Quaternion(3, 0, 0, 0);
  ReplayDevice device(poses);
  Answer renderer;
  device.start(renderer, {}, Clock::Stepped);
  ASSERT_TRUE(device.step());
  ASSERT_TRUE(device.step());
  EXPECT_TRUE(device.status().safety & kBadPose);
  while (device.step()) {
  }
  ASSERT_EQ(renderer.seen.size(), 4u);
  EXPECT_TRUE(std::isnan(renderer.seen[1].handle.position.x()));
  EXPECT_EQ(renderer.seen[2].handle.orientation.w(), 3);
}

TEST(ReplayDevice, EndsByItselfOnTheRealClock) {
  ReplayDevice device(somePoses(40));
  Answer renderer;
  renderer.seen.reserve(100);
  device.start(renderer, {}, Clock::Real);
  for (int n = 0; n < 2000 && device.status().phase == Phase::Running; ++n) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(device.status().phase, Phase::Ended);
  device.stop();
  EXPECT_EQ(renderer.seen.size(), 40u);
}

}  // namespace
}  // namespace spheretree::device

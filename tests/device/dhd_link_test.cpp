// SPDX-License-Identifier: Apache-2.0
#include "links/dhd_link.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdlib>
#include <limits>

#include "fake_dhd/fake_dhd.h"
#include "opened_library.h"
#include "spheretree/device/emergency_stop.h"
#include "spheretree/device/open_device.h"
#include "stepped_link.h"
#include "support/allocations_in.h"
#include "support/random.h"

namespace spheretree::device {
namespace {

struct DhdDevice : testing::Test {
  void* library = test::opened(FAKE_DHD);
  FakeDhdState& fake = *reinterpret_cast<decltype(&fake_dhd_state)>(test::found(library, "fake_dhd_state"))();
  test::Push push;

  DhdDevice() { reinterpret_cast<decltype(&fake_dhd_reset)>(test::found(library, "fake_dhd_reset"))(); }
  void TearDown() override { EXPECT_STREQ(fake.violations, ""); }
  std::unique_ptr<LinkedDevice> device() {
    return std::make_unique<LinkedDevice>(std::make_unique<test::SteppedLink>(std::make_unique<DhdLink>(FAKE_DHD)));
  }
  double force() const { return std::hypot(fake.force[0], fake.force[1], fake.force[2]); }
};

DeviceError failureIn(const std::function<void()>& act) {
  try {
    act();
  } catch (const DeviceError& error) {
    return error;
  }
  return {DeviceFault::None, "it opened"};
}

TEST_F(DhdDevice, FramesAndUnits) {
  fake.has_wrist = 1;
  fake.position[0] = 0.01, fake.position[1] = 0.02, fake.position[2] = 0.03;
  // A quarter turn about the vendor's x axis, which is our z axis.
  const double turned[3][3] = {{1, 0, 0}, {0, 0, -1}, {0, 1, 0}};
  std::copy_n(&turned[0][0], 9, &fake.matrix[0][0]);
  fake.buttons = 6;
  const auto d = device();
  EXPECT_EQ(d->info().model, "sigma.7");
  d->start(push, test::bareSafety(), Clock::Stepped);
  for (int n = 0; n < 20; ++n) d->step();
  EXPECT_TRUE(fake.forces_on && fake.gravity_on);
  EXPECT_LT((push.last.handle.position - Eigen::Vector3d(20, 30, 10)).norm(), 1e-9) << "right, up, to the user";
  EXPECT_LT((push.last.handle.orientation.vec() - Eigen::Vector3d(0, 0, std::sqrt(0.5))).norm(), 1e-9);
  EXPECT_EQ(push.last.buttons, 6u);
  const Eigen::Vector3d f(fake.force), t(fake.torque);
  EXPECT_LT((f - Eigen::Vector3d(0.5, 1, -2)).norm(), 1e-9);
  EXPECT_LT((t - Eigen::Vector3d(-0.005, 0.01, 0.02)).norm(), 1e-12) << "N m";
  d->stop();
  EXPECT_EQ(force(), 0);
  EXPECT_FALSE(fake.forces_on);
}

TEST_F(DhdDevice, ThreeAxesGetTheForceAlone) {
  const auto d = device();
  EXPECT_FALSE(d->info().renders_torque);
  d->start(push, test::bareSafety(), Clock::Stepped);
  for (int n = 0; n < 20; ++n) d->step();
  EXPECT_NEAR(force(), push.wrench.force.norm(), 1e-9);
  EXPECT_EQ(Eigen::Vector3d(fake.torque).norm(), 0);
}

TEST_F(DhdDevice, SaturationIsNoted) {
  const auto d = device();
  d->start(push, test::bareSafety(), Clock::Stepped);
  for (int n = 0; n < 20; ++n) d->step();
  fake.send_result = kDhdMotorSaturated;
  for (int n = 0; n < 3; ++n) d->step();
  EXPECT_EQ(d->status().phase, Phase::Running);
  EXPECT_EQ(d->status().vendor_code, kDhdMotorSaturated);
  EXPECT_GT(force(), 2);
}

TEST_F(DhdDevice, AFaultIsZeroForGood) {
  for (int* const result : {&fake.read_result, &fake.send_result}) {
    const auto d = device();
    d->start(push, test::bareSafety(), Clock::Stepped);
    for (int n = 0; n < 20; ++n) d->step();
    EXPECT_GT(force(), 2);
    *result = -1;
    EXPECT_TRUE(d->step());
    d->step();
    EXPECT_EQ(force(), 0);
    EXPECT_EQ(d->status().phase, Phase::Failed);
    EXPECT_FALSE(d->step());
    *result = 0;
  }
}

TEST_F(DhdDevice, AMatrixThatIsNoRotationIsABadPose) {
  const auto d = device();
  d->start(push, test::bareSafety(), Clock::Stepped);
  d->step();
  fake.matrix[0][0] = -1;  // a mirror
  d->step();
  EXPECT_TRUE(d->status().safety & kBadPose);
  EXPECT_EQ(force(), 0);
}

TEST_F(DhdDevice, SaysWhatIsMissing) {
  EXPECT_EQ(failureIn([] { DhdLink(FAKE_DHD_INCOMPLETE); }).fault, DeviceFault::SymbolMissing);
  const DeviceError none = failureIn([] { DhdLink("/nowhere/libdhd.so"); });
  EXPECT_EQ(none.fault, DeviceFault::LibraryMissing);
  EXPECT_NE(std::string(none.what()).find("--dhd-library"), std::string::npos);
  if (!test::opened(dhdLibraryNames().front())) {
    const std::string message = failureIn([] { openDevice("dhd", {}); }).what();
    for (const std::string& name : dhdLibraryNames()) EXPECT_NE(message.find(name + ": "), std::string::npos) << message;
  }
  fake.unplugged = 1;
  const DeviceError unplugged = failureIn([] { DhdLink(FAKE_DHD); });
  EXPECT_EQ(unplugged.fault, DeviceFault::NotFound);
  EXPECT_NE(std::string(unplugged.what()).find("device not found"), std::string::npos);
  fake.unplugged = 0;
  fake.start_fails = 1;
  const auto d = device();
  EXPECT_EQ(failureIn([&] { d->start(push, SafetySettings(), Clock::Stepped); }).fault, DeviceFault::Communication);
}

/// The rules of the table in docs/device.md, each broken once, through a whole device. The device layer has them once;
/// tests/device/safety_test.cpp shows their figures.
TEST_F(DhdDevice, EachSafetyRuleActs) {
  const auto d = device();
  d->start(push, SafetySettings(), Clock::Stepped);
  const auto steps = [&](int count) {
    for (int n = 0; n < count; ++n) d->step();
    return d->status().safety;
  };
  push.wrench = {{3, 0, 0}, {0, 0, 0}};
  EXPECT_TRUE(steps(100) & kStartGuard);
  EXPECT_EQ(fake.largest_force, 0);
  const auto settle = [&] {
    push.wrench.force.setZero();
    steps(20);
    push.wrench.force = {3, 0, 0};
    return steps(2200);
  };
  EXPECT_FALSE(settle() & kRamp);
  EXPECT_NEAR(force(), 3, 1e-9);
  fake.buttons = 1;
  EXPECT_TRUE(steps(1) & kReleased);
  EXPECT_EQ(force(), 0);
  fake.buttons = 0;
  settle();
  fake.position[0] = 1;
  EXPECT_TRUE(steps(1) & kBadPose);
  EXPECT_EQ(force(), 0);
  settle();
  push.wrench.force = {1000, 0, 0};
  EXPECT_TRUE(steps(1) & kSlewLimited);
  EXPECT_NEAR(force(), 3.5, 1e-9);
  EXPECT_TRUE(steps(100) & kForceClamped);
  EXPECT_NEAR(force(), 8, 1e-9);
  for (int n = 0; n < 20; ++n) {
    fake.position[0] += 2e-3;
    steps(1);
  }
  EXPECT_TRUE(d->status().safety & kTooFast);
  EXPECT_LT(force(), 8);
  push.wrench.force.setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_TRUE(steps(250) & kRendererFailed);
  EXPECT_TRUE(d->status().safety & kForcesOff);
  EXPECT_EQ(force(), 0);
  d->rearm();
  settle();
  EXPECT_NEAR(force(), 3, 1e-9);
  const EmergencyStop stop;
  EmergencyStop::request();
  EXPECT_TRUE(steps(1) & kEmergencyStop);
  EXPECT_EQ(force(), 0);
  EXPECT_EQ(d->status().phase, Phase::Halted);
}

/// SPHERETREE_LONG=1: 10^7.
TEST_F(DhdDevice, NoInputSendsMoreThanTheLimitsOrAllocates) {
  spheretree::test::Random random(5);
  const auto d = device();
  d->start(push, test::bareSafety(), Clock::Stepped);
  const auto number = [&](double scale) {
    return random.below(100) > 0
               ? random.between(-scale, scale)
               : std::bit_cast<double>((static_cast<std::uint64_t>(random.below(1u << 31)) << 33) ^ random.below(1u << 31));
  };
  d->step();
  const long count = std::getenv("SPHERETREE_LONG") ? 10'000'000 : 1'000'000;
  EXPECT_EQ(spheretree::test::allocationsIn([&] {
              for (long n = 0; n < count; ++n) {
                for (double& p : fake.position) p = number(1e-3);
                fake.matrix[1][1] = random.below(50) == 0 ? number(2) : 1;
                fake.buttons = random.below(1000) == 0 ? static_cast<unsigned>(random.below(1u << 31)) : 0;
                push.wrench.force = {number(30), number(30), number(30)};
                push.wrench.torque = {number(900), number(900), number(900)};
                if (random.below(50) == 0) d->rearm();
                d->step();
              }
            }),
            0);
  EXPECT_LE(fake.largest_force, 8 * (1 + 1e-12));
  EXPECT_GT(fake.largest_force, 7) << "the test looks away";
  push.wrench = {};
}

}  // namespace
}  // namespace spheretree::device

// SPDX-License-Identifier: Apache-2.0
// Every fault that HDAPI can report, injected: the wrench is zero within two ticks.
#include <csignal>

#include "fake_libhd/fake_controls.h"
#include "spheretree/device/emergency_stop.h"

namespace spheretree::device {
namespace {

TEST_F(PhantomDevice_, AnInvalidRotationIsNotRendered) {
  settings.matrix_error = 0.5;
  reset();
  PhantomDevice device(phantom);
  Constant renderer;
  device.start(renderer, safety, Clock::Real);
  fake().step(100);
  EXPECT_TRUE(device.status().safety & kBadPose);
  EXPECT_EQ(asked(99).norm(), 0);
}

TEST_F(PhantomDevice_, LostCommunicationIsZeroWithinTwoTicksAndForGood) {
  for (const std::uint32_t code : {0x0300u, 0x0302u, 0x0303u, 0x0304u, 0x0500u, 0x0501u, 0x0104u, 0x0400u, 0x0402u}) {
    reset();
    PhantomDevice device(phantom);
    Constant renderer;
    device.start(renderer, safety, Clock::Real);
    fake().inject(50, code, -28);
    fake().step(200);
    EXPECT_GT(asked(50).norm(), 1);
    for (long n = 51; n < 200; ++n) ASSERT_EQ(asked(n).norm() + askedTorque(n).norm(), 0) << std::hex << code << " tick " << n;
    const DeviceStatus status = device.status();
    EXPECT_EQ(status.phase, Phase::Failed);
    EXPECT_EQ(status.fault, DeviceFault::Communication);
    EXPECT_EQ(status.vendor_code, static_cast<std::int32_t>(code));
    EXPECT_TRUE(status.safety_so_far & kDeviceFailed);
    EXPECT_TRUE(fake().record(53).framed) << "zero is sent, not only no longer anything";
    EXPECT_FALSE(fake().record(60).framed) << "and then the servo ends";
    device.rearm();
    device.stop();
    EXPECT_EQ(device.status().phase, Phase::Failed);
    EXPECT_STREQ(fake().violations(), "");
  }
}

TEST_F(PhantomDevice_, AForceErrorBeginsTheGuardAndTheRampAnew) {
  for (const std::uint32_t code : {0x0200u, 0x0201u, 0x0202u, 0x0203u, 0x0204u}) {
    reset();
    PhantomDevice device(phantom);
    Constant renderer;
    device.start(renderer, safety, Clock::Real);
    fake().inject(50, code, 0);
    fake().step(100);
    for (long n = 51; n < 100; ++n) ASSERT_EQ(asked(n).norm(), 0) << std::hex << code << " tick " << n;
    EXPECT_EQ(device.status().phase, Phase::Running);
    EXPECT_EQ(device.status().vendor_code, static_cast<std::int32_t>(code));
    EXPECT_EQ((device.status().safety_so_far & kWarmMotors) != 0, code == 0x0200);
    const Wrench full = renderer.wrench;
    renderer.wrench = {};
    fake().step(10);
    renderer.wrench = full;
    fake().step(1000);
    EXPECT_NEAR(asked(1109).norm(), full.force.norm() / 2, 0.02) << "half of the ramp of two seconds";
  }
}

TEST_F(PhantomDevice_, ButtonAndSafetySwitchTakeTheForceOff) {
  settings.has_switch = true;
  reset();
  PhantomDevice device(phantom);
  Constant renderer;
  device.start(renderer, safety, Clock::Real);
  fake().step(10);
  EXPECT_GT(asked(9).norm(), 1);
  fake().set(0, false);
  fake().step(1);
  EXPECT_EQ(asked(10).norm(), 0);
  renderer.wrench = {};
  fake().set(0, true);
  fake().step(10);
  renderer.wrench.force = {1, 0, 0};
  fake().step(100);
  EXPECT_GT(asked(120).norm(), 0.01);
  fake().set(1, true);
  fake().step(1);
  EXPECT_EQ(asked(121).norm(), 0);
  EXPECT_EQ(renderer.last.buttons, 1u);
}

TEST_F(PhantomDevice_, WarmMotorsAreSpared) {
  settings.temperature_per_second = 0.5;
  reset();
  PhantomDevice device(phantom);
  Constant renderer;
  renderer.wrench = {{8, 0, 0}, {0, 0, 0}};
  device.start(renderer, safety, Clock::Real);
  fake().step(1000);
  EXPECT_NEAR(asked(999).norm(), 8, 1e-9);
  fake().step(2500);
  EXPECT_NEAR(asked(3499).norm(), 3, 1e-9) << "the continuous force that the library states";
}

TEST_F(PhantomDevice_, StopAndDestructorSendZeroFirst) {
  {
    PhantomDevice device(phantom);
    Constant renderer;
    device.start(renderer, safety, Clock::Real);
    fake().step(100);
    EXPECT_TRUE(fake().running());
  }
  EXPECT_FALSE(fake().running());
  for (long n = fake().ticks() - 2; n < fake().ticks(); ++n) EXPECT_EQ(asked(n).norm(), 0);
}

TEST_F(PhantomDevice_, AFailedStartLeavesNothingBehind) {
  settings.start_fails = true;
  reset();
  {
    PhantomDevice device(phantom);
    Constant renderer;
    try {
      device.start(renderer, safety, Clock::Real);
      ADD_FAILURE() << "started";
    } catch (const DeviceError& error) {
      EXPECT_EQ(error.fault, DeviceFault::Communication);
      EXPECT_NE(std::string(error.what()).find("Timer error (0x0304"), std::string::npos) << error.what();
    }
    EXPECT_EQ(device.status().phase, Phase::Stopped);
    EXPECT_EQ(renderer.calls, 0);
  }
  EXPECT_FALSE(fake().running());
}

TEST_F(PhantomDevice_, EmergencyStopTakesTheForceOffAtTheNextTick) {
  EmergencyStop stop;
  PhantomDevice device(phantom);
  Constant renderer;
  device.start(renderer, safety, Clock::Real);
  fake().step(10);
  std::raise(SIGINT);
  fake().step(10);
  for (long n = 10; n < 20; ++n) EXPECT_EQ(asked(n).norm(), 0);
  EXPECT_EQ(device.status().phase, Phase::Halted);
}

}  // namespace
}  // namespace spheretree::device

// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/phantom_device.h"

#include <chrono>
#include <cstdlib>
#include <thread>

#include "fake_libhd/fake_controls.h"
#include "support/count_allocations.h"

namespace spheretree::device {
namespace {

TEST_F(PhantomDevice_, CallsInTheOrderThatHdapiWants) {
  {
    PhantomDevice device(phantom);
    Constant renderer;
    device.start(renderer, safety, Clock::Real);
    fake().step(10);
    device.stop();
  }
  EXPECT_STREQ(fake().calls(),
               "hdInitDevice hdGetError hdMakeCurrentDevice hdGetError hdCheckCalibration hdGetError "
               "hdMakeCurrentDevice hdEnable hdGetError hdEnable hdGetError hdEnable hdSetSchedulerRate hdScheduleAsynchronous hdGetError "
               "hdStartScheduler hdGetError "
               "hdStopScheduler hdUnschedule hdGetError hdDisableDevice");
}

TEST_F(PhantomDevice_, ReportsItsProperties) {
  PhantomDevice device(phantom);
  EXPECT_EQ(device.info().model, "PHANTOM Premium 3.0 6DOF");
  EXPECT_EQ(device.info().serial, "A3001");
  EXPECT_NE(device.info().driver.find("4.3.3"), std::string::npos);
  EXPECT_EQ(device.info().max_force, 22);
  EXPECT_EQ(device.info().continuous_force, 3);
  EXPECT_TRUE(device.info().renders_torque);
  Constant renderer;
  EXPECT_THROW(device.start(renderer, safety, Clock::Stepped), DeviceError);
}

TEST_F(PhantomDevice_, APauseIsZeroForceAndEndsGently) {
  PhantomDevice device(phantom);
  Constant renderer;
  device.start(renderer, safety, Clock::Real);
  fake().step(50);
  EXPECT_FALSE(device.setPace(2)) << "a hand does not slow down";
  EXPECT_FALSE(device.stepOnce());
  EXPECT_FALSE(device.restart());
  ASSERT_TRUE(device.setPace(0));
  const std::uint64_t before = device.status().ticks;
  fake().step(50);
  EXPECT_EQ(device.status().ticks, before) << "the renderer is not called";
  for (long n = 50; n < 100; ++n) EXPECT_EQ(asked(n), Eigen::Vector3d(0, 0, 0)) << n;
  EXPECT_TRUE(device.status().safety & kReleased);
  ASSERT_TRUE(device.setPace(1));
  fake().step(1);
  EXPECT_EQ(device.status().ticks, before + 1);
  EXPECT_TRUE(device.status().safety & kStartGuard);
}

TEST_F(PhantomDevice_, TriesTheDefaultNameWhereTheNullNameFails) {
  settings.null_name_fails = true;
  reset();
  EXPECT_EQ(failure().fault, DeviceFault::None);
  phantom.device = "Default PHANToM";
  EXPECT_EQ(failure().fault, DeviceFault::None);
}

TEST_F(PhantomDevice_, SaysInTheVendorsWordsWhyThereIsNoDevice) {
  settings.unplugged = true;
  reset();
  const DeviceError error = failure();
  EXPECT_EQ(error.fault, DeviceFault::NotFound);
  EXPECT_NE(std::string(error.what()).find("Default PHANToM: Device fault (0x0300, internal -5)"), std::string::npos) << error.what();
  settings.unplugged = false;
  reset();
  phantom.device = "Left";
  EXPECT_EQ(failure().fault, DeviceFault::NotFound);
  phantom.device.clear();
  phantom.vendor = "nobody";
  EXPECT_EQ(failure().fault, DeviceFault::Refused);
}

TEST_F(PhantomDevice_, AsksForCalibrationAndDoesItWhenTold) {
  settings.calibrated = false;
  reset();
  EXPECT_EQ(failure().fault, DeviceFault::NotCalibrated) << "an encoder reset is true only in the reset pose: a person must say so";
  phantom.calibrate = true;
  EXPECT_EQ(failure().fault, DeviceFault::None);
  settings.calibration_fails = true;
  reset();
  EXPECT_EQ(failure().fault, DeviceFault::NotCalibrated);
  settings.calibration_fails = false;
  settings.calibration_style = 2;
  phantom.calibrate = false;
  reset();
  EXPECT_EQ(failure().fault, DeviceFault::None) << "automatic";
  settings.calibration_style = 4;
  reset();
  EXPECT_NE(std::string(failure().what()).find("inkwell"), std::string::npos);
}

TEST_F(PhantomDevice_, ReadsThePoseOfAMatrixThatIsSlightlyOff) {
  settings.matrix_error = 1e-3;
  settings.path = [](double time, double* p, double* q) {
    const Quaternion turn = rotationOf({0.3 + 0.2 * time, -0.5, 0.4});
    p[0] = 10 + 20 * time, p[1] = -5, p[2] = 3;
    q[0] = turn.w(), q[1] = turn.x(), q[2] = turn.y(), q[3] = turn.z();
  };
  reset();
  PhantomDevice device(phantom);
  Constant renderer;
  renderer.wrench = {};
  device.start(renderer, safety, Clock::Real);
  fake().step(1);  // the hand starts at the beginning of its path
  EXPECT_LT((renderer.last.handle.position - Eigen::Vector3d(10, -5, 3)).norm(), 1e-12);
  EXPECT_LT(rotationVector(renderer.last.handle.orientation * rotationOf({0.3, -0.5, 0.4}).conjugate()).norm(), 1e-9);
  EXPECT_NEAR(renderer.last.handle.orientation.norm(), 1, 1e-15);
  fake().step(1000);
  EXPECT_GT(renderer.last.handle.position.x(), 25);
}

TEST_F(PhantomDevice_, SendsWhatWasRendered) {
  PhantomDevice device(phantom);
  Constant renderer;
  device.start(renderer, safety, Clock::Real);
  fake().step(2000);
  for (long n = 0; n < 2000; ++n) {
    ASSERT_LT((asked(n) - renderer.wrench.force).norm(), 1e-9) << n;
    ASSERT_LT((askedTorque(n) - renderer.wrench.torque).norm(), 1e-9) << n;
  }
  const FakeRecord& last = fake().record(1999);
  EXPECT_LT((Eigen::Vector3d(last.force) - renderer.wrench.force).norm(), 1e-9) << "after the vendor's ramp";
  EXPECT_TRUE(last.framed);
}

/// The fake solves for the torque with these components along its joint axes: the same vector must arrive at the
/// motors.
TEST_F(PhantomDevice_, GimbalTorqueIsTheSameTorqueAboutTheJoints) {
  settings.path = [](double time, double* p, double* q) {
    const Quaternion turn = rotationOf({0.8 * time, -0.5 + time, 0.6 * time});
    p[0] = p[1] = p[2] = 0;
    q[0] = turn.w(), q[1] = turn.x(), q[2] = turn.y(), q[3] = turn.z();
  };
  reset();
  phantom.torque = TorqueConvention::Gimbal;
  PhantomDevice device(phantom);
  Constant renderer;
  device.start(renderer, safety, Clock::Real);
  fake().step(1800);
  int skewed = 0;
  for (long n = 1100; n < 1800; ++n) {  // the vendor's ramp is over
    ASSERT_LT((Eigen::Vector3d(fake().record(n).torque) - renderer.wrench.torque).norm(), 1e-9) << n;
    skewed += (askedTorque(n) - renderer.wrench.torque).norm() > 1;
  }
  EXPECT_GT(skewed, 500) << "the joints should not be the device's axes here";
}

TEST_F(PhantomDevice_, NoTorqueForADeviceThatHasNone) {
  settings.output_dof = 3;
  reset();
  PhantomDevice device(phantom);
  EXPECT_FALSE(device.info().renders_torque);
  Constant renderer;
  device.start(renderer, safety, Clock::Real);
  fake().step(100);
  EXPECT_EQ(device.status().phase, Phase::Running);
  EXPECT_EQ(askedTorque(99).norm(), 0);
  EXPECT_GT(asked(99).norm(), 1);
}

TEST_F(PhantomDevice_, AModelMayLackWhatIsNotNeeded) {
  settings.poor = true;
  reset();
  PhantomDevice device(phantom);
  EXPECT_EQ(device.info().serial, "");
  Constant renderer;
  device.start(renderer, safety, Clock::Real);
  fake().step(100);
  EXPECT_EQ(device.status().phase, Phase::Running) << std::hex << device.status().vendor_code;
  EXPECT_LT((asked(99) - renderer.wrench.force).norm(), 1e-9);
}

TEST_F(PhantomDevice_, StartsAgainAfterAStop) {
  PhantomDevice device(phantom);
  Constant renderer;
  for (int run = 0; run < 3; ++run) {
    device.start(renderer, safety, Clock::Real);
    fake().step(20);
    EXPECT_EQ(device.status().ticks, 20u);
    EXPECT_GT(asked(fake().ticks() - 1).norm(), 1);
    device.stop();
    EXPECT_EQ(device.status().phase, Phase::Stopped);
  }
}

TEST_F(PhantomDevice_, RunsOnTheSchedulersOwnClock) {
  settings.stepped = false;
  reset();
  PhantomDevice device(phantom);
  Constant renderer;
  device.start(renderer, safety, Clock::Real);
  for (int n = 0; n < 2000 && device.status().ticks < 50; ++n) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_GE(device.status().ticks, 50u);
  device.stop();
  EXPECT_EQ(device.status().phase, Phase::Stopped);
}

/// SPHERETREE_LONG=1: 10^7.
TEST_F(PhantomDevice_, NoTickAllocates) {
  PhantomDevice device(phantom);
  Constant renderer;
  device.start(renderer, SafetySettings(), Clock::Real);
  fake().step(100);
  const int ticks = std::getenv("SPHERETREE_LONG") ? 10'000'000 : 100'000;
  EXPECT_EQ(spheretree::test::allocationsIn([&] { fake().step(ticks); }), 0);
  EXPECT_EQ(renderer.calls, ticks + 100);
  EXPECT_EQ(spheretree::test::allocationsIn([] { ::operator delete(::operator new(4)); }), 1) << "allocations are not counted";
}

}  // namespace
}  // namespace spheretree::device

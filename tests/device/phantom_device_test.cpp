// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/phantom_device.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <new>
#include <thread>

#include "fake_libhd/fake_libhd.h"
#include "spheretree/device/emergency_stop.h"

namespace {
std::atomic<long> allocations{0};
}
// Counted, so that a servo step can be shown to do without.
void* operator new(std::size_t size) {
  allocations.fetch_add(1, std::memory_order_relaxed);
  if (void* memory = std::malloc(size ? size : 1)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace spheretree::device {
namespace {

/// The controls of the fake, from the same copy of it that the device loads.
struct Fake {
  void* library = dlopen(FAKE_LIBHD, RTLD_NOW | RTLD_LOCAL);
#define CONTROL(name) decltype(&::fake_##name) name = reinterpret_cast<decltype(&::fake_##name)>(dlsym(library, "fake_" #name))
  CONTROL(reset);
  CONTROL(step);
  CONTROL(inject);
  CONTROL(set);
  CONTROL(ticks);
  CONTROL(record);
  CONTROL(violations);
  CONTROL(calls);
  CONTROL(running);
#undef CONTROL
  template <class Function>
  Function* hd(const char* name) const {
    return reinterpret_cast<Function*>(dlsym(library, name));
  }
};

const Fake& fake() {
  static const Fake controls;
  return controls;
}

struct ErrorInfo {
  std::uint32_t code;
  std::int32_t internal;
  std::uint32_t device;
};

/// The fake's defaults and bare rules: no guard, no slew limit, unless a test is about them.
struct PhantomDevice_ : testing::Test {
  FakeSettings settings;
  PhantomSettings phantom;
  SafetySettings safety;

  PhantomDevice_() {
    phantom.library = FAKE_LIBHD;
    safety.start_guard = false;
    safety.force_slew = safety.torque_slew = 1e6;
    safety.stale_after = safety.off_after = 1e6;  // time is the fake's, but the pauses of a busy machine are real
    fake().reset(&settings);
  }
  void TearDown() override { EXPECT_STREQ(fake().violations(), ""); }
  void reset() { fake().reset(&settings); }
  DeviceError failure() {
    try {
      PhantomDevice device(phantom);
    } catch (const DeviceError& error) {
      return error;
    }
    return {DeviceFault::None, "it opened"};
  }
};

struct Constant final : Renderer {
  Wrench wrench{{1, -2, 0.5}, {10, 20, -5}};
  DeviceState last;
  long calls = 0;
  Rendered render(const DeviceState& state) noexcept override {
    last = state;
    ++calls;
    return {wrench, 0, false};
  }
};

Eigen::Vector3d asked(long tick) { return Eigen::Vector3d(fake().record(tick).asked); }
Eigen::Vector3d askedTorque(long tick) { return Eigen::Vector3d(fake().record(tick).asked_torque); }

TEST_F(PhantomDevice_, SaysInTheLoadersWordsWhyThereIsNoLibrary) {
  phantom.library = "/nowhere/libHD.so";
  const DeviceError error = failure();
  EXPECT_EQ(error.fault, DeviceFault::LibraryMissing);
  EXPECT_NE(std::string(error.what()).find("/nowhere/libHD.so: cannot open shared object file: No such file"), std::string::npos)
      << error.what();
  phantom.library.clear();
  if (dlopen("libHD.so", RTLD_NOW | RTLD_LOCAL)) GTEST_SKIP() << "OpenHaptics is installed here";
  const std::string message = failure().what();
  for (const char* name : {"libHD.so: ", "libHD.so.3.4: ", "libHD.so.3.0: "}) EXPECT_NE(message.find(name), std::string::npos) << message;
}

TEST_F(PhantomDevice_, NamesTheFirstMissingFunction) {
  phantom.library = FAKE_LIBHD_INCOMPLETE;
  const DeviceError error = failure();
  EXPECT_EQ(error.fault, DeviceFault::SymbolMissing);
  EXPECT_NE(std::string(error.what()).find("hdGetErrorString"), std::string::npos) << error.what();
}

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

TEST_F(PhantomDevice_, TellsWhatItIs) {
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
  fake().step(1);  // the hand starts where its path does
  EXPECT_LT((renderer.last.tool.position - Eigen::Vector3d(10, -5, 3)).norm(), 1e-12);
  EXPECT_LT(rotationVector(renderer.last.tool.orientation * rotationOf({0.3, -0.5, 0.4}).conjugate()).norm(), 1e-9);
  EXPECT_NEAR(renderer.last.tool.orientation.norm(), 1, 1e-15);
  fake().step(1000);
  EXPECT_GT(renderer.last.tool.position.x(), 25);
}

TEST_F(PhantomDevice_, ARotationThatIsNoneIsNotRendered) {
  settings.matrix_error = 0.5;
  reset();
  PhantomDevice device(phantom);
  Constant renderer;
  device.start(renderer, safety, Clock::Real);
  fake().step(100);
  EXPECT_TRUE(device.status().safety & kBadPose);
  EXPECT_EQ(asked(99).norm(), 0);
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

/// The fake solves for the torque that has these parts along its joint axes: the same vector must come out at the motors.
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

TEST_F(PhantomDevice_, TheLibraryStaysLoaded) {
  const char* name = FAKE_LIBHD_INCOMPLETE;
  phantom.library = name;
  failure();
  void* still = dlopen(name, RTLD_NOW | RTLD_NOLOAD);
  EXPECT_NE(still, nullptr);
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
TEST_F(PhantomDevice_, AMillionTicksWithoutAllocation) {
  PhantomDevice device(phantom);
  Constant renderer;
  device.start(renderer, SafetySettings(), Clock::Real);
  fake().step(100);
  const int ticks = std::getenv("SPHERETREE_LONG") ? 10'000'000 : 1'000'000;
  const long before = allocations;
  fake().step(ticks);
  EXPECT_EQ(allocations - before, 0);
  EXPECT_EQ(renderer.calls, ticks + 100);
  EXPECT_GT(before, 0) << "allocations are not counted";
}

/// The fake itself: each rule that it is to check is broken once.
struct FakeLibHd : testing::Test {
  FakeSettings settings;
  FakeLibHd() { fake().reset(&settings); }
  std::uint32_t error() const { return fake().hd<ErrorInfo()>("hdGetError")().code; }
  bool broken(const char* rule) const { return std::string(fake().violations()).find(rule) != std::string::npos; }
  template <class... A>
  void call(const char* name, A... arguments) const {
    fake().hd<void(A...)>(name)(arguments...);
  }
};

TEST_F(FakeLibHd, FramesOutOfPlaceAreErrors) {
  fake().hd<std::uint32_t(const char*)>("hdInitDevice")(nullptr);
  const double force[3] = {1, 0, 0};
  call("hdSetDoublev", 0x2700u, force);
  EXPECT_EQ(error(), 0x0402u);
  call("hdEndFrame", 7u);
  EXPECT_EQ(error(), 0x0401u);
  call("hdBeginFrame", 7u);
  call("hdBeginFrame", 7u);
  EXPECT_EQ(error(), 0x0400u);
  call("hdSetDoublev", 0x2710u, force);
  EXPECT_EQ(error(), 0x0100u);
  double out[16];
  call("hdGetDoublev", 0x2000u, out);
  EXPECT_EQ(error(), 0x0103u);
  call("hdEndFrame", 8u);
  EXPECT_EQ(error(), 0x0104u);
  EXPECT_EQ(error(), 0u);
}

TEST_F(FakeLibHd, BrokenRulesAreSeen) {
  call("hdEnable", 0x4000u);
  EXPECT_TRUE(broken("without an open device"));
  fake().reset(&settings);
  fake().hd<std::uint32_t(const char*)>("hdInitDevice")(nullptr);
  call("hdStartScheduler");
  EXPECT_TRUE(broken("before anything was scheduled"));
  EXPECT_TRUE(broken("before the force output was enabled"));
  double out[16];
  call("hdGetDoublev", 0x2052u, out);
  EXPECT_TRUE(broken("from another thread while the scheduler runs"));
  EXPECT_EQ(error(), 0x0402u);
  call("hdDisableDevice", 7u);
  EXPECT_TRUE(broken("disabled while the scheduler runs"));
}

std::uint32_t careless(void*) {  // sends a force for ever and never asks for errors
  const double force[3] = {1, 0, 0};
  fake().hd<void(std::uint32_t)>("hdBeginFrame")(7);
  fake().hd<void(std::uint32_t, const double*)>("hdSetDoublev")(0x2700, force);
  fake().hd<void(std::uint32_t)>("hdEndFrame")(7);
  return 1;
}

TEST_F(FakeLibHd, CarelessServosAreSeen) {
  fake().hd<std::uint32_t(const char*)>("hdInitDevice")(nullptr);
  call("hdEnable", 0x4000u);
  fake().hd<unsigned long(std::uint32_t(*)(void*), void*, std::uint16_t)>("hdScheduleAsynchronous")(careless, nullptr, 100);
  EXPECT_TRUE(broken("highest priority"));
  call("hdStartScheduler");
  fake().inject(3, 0x0201, 0);
  fake().step(10);
  EXPECT_TRUE(broken("not drained in the servo"));
  call("hdUnschedule", 1ul);
  EXPECT_TRUE(broken("unscheduled while the scheduler runs"));
  fake().step(1);
  EXPECT_TRUE(broken("left a force"));
  fake().reset(&settings);
  fake().hd<std::uint32_t(const char*)>("hdInitDevice")(nullptr);
  call("hdEnable", 0x4000u);
  fake().hd<unsigned long(std::uint32_t(*)(void*), void*, std::uint16_t)>("hdScheduleAsynchronous")(careless, nullptr, 65535);
  call("hdStartScheduler");
  fake().step(5);
  call("hdStopScheduler");
  EXPECT_TRUE(broken("without some ticks of zero force"));
}

}  // namespace
}  // namespace spheretree::device

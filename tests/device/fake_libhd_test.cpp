// SPDX-License-Identifier: Apache-2.0
#include "fake_libhd/fake_libhd.h"

#include "fake_libhd/fake_controls.h"

namespace spheretree::device {
namespace {

struct ErrorInfo {
  std::uint32_t code;
  std::int32_t internal;
  std::uint32_t device;
};

/// Tests of the fake: each rule that it checks is broken once.
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

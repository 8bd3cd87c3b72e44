// SPDX-License-Identifier: Apache-2.0
#include "links/haply_link.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <thread>

#include "fake_haply.h"
#include "links/net_address.h"
#include "spheretree/device/open_device.h"
#include "stepped_link.h"
#include "support/allocations_in.h"
#include "support/random.h"

namespace spheretree::device {
namespace {

using test::FakeHaply;

const char* const kMessage =
    R"({"inverse3":[{"state":{"cursor_position":{"z":0.3,"x":0.1,"y":-0.2}},"device_id":"A","config":{"handedness":"left"}},)"
    R"({"device_id":"B","state":{"cursor_position":{"x":1,"y":2,"z":3}}}],)"
    R"("verse_grip":[{"state":{"orientation":{"w":0.8,"x":0.6,"y":0,"z":0},"buttons":{"a":false,"b":true,"c":true,"d":true}}}]})";

std::unique_ptr<HaplyLink> linkTo(const FakeHaply& fake, const std::string& device = "") {
  return std::make_unique<HaplyLink>(addressOf(fake.host(), false, "haply"), fake.host(), device);
}

std::string failureTo(const std::function<void()>& act, DeviceFault fault) {
  try {
    act();
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.fault, fault) << error.what();
    return error.what();
  }
  ADD_FAILURE() << "it opened";
  return {};
}

TEST(HaplyMessage, MembersComeInAnyOrder) {
  const HaplyMessage first = readHaply(kMessage, ""), second = readHaply(kMessage, "B");
  ASSERT_TRUE(first.has_pose && second.has_pose);
  EXPECT_EQ(first.device, "A");
  EXPECT_EQ(first.handedness, "left");
  EXPECT_EQ(second.position, Eigen::Vector3d(1, 2, 3));
  EXPECT_EQ(second.handedness, "");
  EXPECT_EQ(first.buttons, 6u);
  EXPECT_FALSE(readHaply(kMessage, "C").has_arm);
  // +y away from the user is our -z, +z up is our +y; a turn about x stays one.
  const Configuration pose = poseOfHaply(first);
  EXPECT_LT((pose.position - Eigen::Vector3d(100, 300, 200)).norm(), 1e-9);
  EXPECT_LT((pose.orientation.vec() - Eigen::Vector3d(0.6, 0, 0)).norm(), 1e-12);
}

TEST(HaplyMessage, AForceComesBackInTheVendorsFrame) {
  std::array<char, 512> text;
  const std::size_t size = writeHaply("A1", {1, 2, 3}, text);
  EXPECT_EQ(std::string(text.data(), size),
            R"({"inverse3":[{"device_id":"A1","commands":{"set_cursor_force":{"values":{"x":1,"y":-3,"z":2}}}}]})");
  EXPECT_EQ(writeHaply("A1", {1, 2, 3}, std::span(text).first(size)), 0u) << "no space for the end: nothing is sent";
}

TEST(HaplyMessage, NothingOfABrokenTextIsUsed) {
  const std::string whole = kMessage;
  for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_FALSE(readHaply(whole.substr(0, size), "").has_pose) << size;
  for (const char* bad : {"[]", "{}", "null", R"({"inverse3":[{"device_id":"A","state":{"cursor_position":{"x":1,"y":2}}}]})",
                          R"({"inverse3":[{"state":{"cursor_position":{"x":1,"y":2,"z":3}}}]})"})
    EXPECT_FALSE(readHaply(bad, "").has_pose) << bad;
  const std::string deep(100'000, '[');
  EXPECT_FALSE(readHaply(deep, "").has_arm);
  const HaplyMessage words = readHaply(R"({"inverse3":[{"device_id":"A","state":{"cursor_position":{"x":"up","y":2,"z":3}}}]})", "");
  EXPECT_TRUE(words.has_pose && std::isnan(words.position.x())) << "the rule for bad poses has to see it";
}

/// A message of the service with some of its bytes changed, in `frame` as it is sent.
void disturbedFrame(spheretree::test::Random& random, std::string& text, std::string& frame) {
  text = kMessage;
  const std::size_t changes = random.below(4);
  for (std::size_t n = 0; n < changes; ++n) text[random.below(text.size())] = static_cast<char>(random.below(256));
  if (random.below(8) == 0) text.resize(random.below(text.size()));
  frame.assign(1, '\x81');
  frame += '\x7e';
  frame += static_cast<char>(text.size() >> 8);
  frame += static_cast<char>(text.size() & 0xff);
  frame += text;
  if (random.below(50) == 0) frame[random.below(4)] = static_cast<char>(random.below(256));
}

/// The only thing between a hostile service and a hand are the safety rules; no message gets past them, none allocates,
/// and the reader never leaves its buffers. SPHERETREE_LONG=1: 10^7.
TEST(HaplyMessage, NoMessageSendsMoreThanTheLimits) {
  spheretree::test::Random random(11);
  WebSocketReader reader;
  SafetySettings settings = test::bareSafety();
  settings.pose_jump = 1e5;  // else hardly any of these poses would be rendered
  settings.fade_speed = 1e6;
  settings.ramp = 0.001;
  Safety safety(settings);
  const long messages = std::getenv("SPHERETREE_LONG") ? 10'000'000 : 1'000'000;
  long poses = 0, forces = 0, broken = 0;
  std::string text, frame;
  text.reserve(1024), frame.reserve(2048);
  DeviceState state;
  bool is_broken = false;
  const auto wave = [&] {
    if (is_broken) return;
    disturbedFrame(random, text, frame);
    std::size_t at = 0;
    while (at < frame.size()) {
      const std::span<char> space = reader.space();
      ASSERT_FALSE(space.empty());
      const std::size_t piece = std::min({space.size(), frame.size() - at, std::size_t{1} + random.below(400)});
      std::copy_n(frame.data() + at, piece, space.data());
      reader.received(piece);
      at += piece;
      for (WebSocketReader::Found found; (found = reader.next()) != WebSocketReader::Found::Nothing;) {
        if (found == WebSocketReader::Found::Broken) {
          ++broken;
          is_broken = true;  // the connection would be closed
          return;
        }
        if (found != WebSocketReader::Found::Text) continue;
        const HaplyMessage message = readHaply(reader.payload(), "A");
        if (!message.has_pose) continue;
        ++poses;
        state.handle = poseOfHaply(message);
        state.buttons = message.buttons & ~1u;
        state.time += 1e-3;
        const double scale = poses % 50 < 10 ? 1e-9 : 1;  // gentle at times, so that the start guard lets it through
        const Wrench sent = safety.limit(state, {{scale * state.handle.position, 3 * scale * state.handle.position}, 0, false});
        ASSERT_TRUE(sent.force.allFinite() && sent.torque.allFinite());
        ASSERT_LE(sent.force.norm(), settings.max_force * (1 + 1e-12));
        forces += sent.force.norm() > 0;
      }
    }
  };
  const auto waves = [&](int count) {
    for (int k = 0; k < count; ++k) wave();
  };
  waves(100);
  for (long n = 0; n < messages; n += 25) {
    reader = WebSocketReader();
    is_broken = false;
    EXPECT_EQ(spheretree::test::allocationsIn([&] { waves(25); }), 0);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(poses, messages / 10);
  EXPECT_GT(forces, poses / 100) << "the test looks away";
  EXPECT_GT(broken, 0);
}

TEST(HaplyDevice, PosesComeAndForcesGo) {
  FakeHaply fake;
  fake.x = 0.01, fake.y = -0.12, fake.z = 0.2;
  LinkedDevice device(std::make_unique<test::SteppedLink>(linkTo(fake)));
  EXPECT_EQ(device.info().model, "Haply Inverse3, right-handed");
  EXPECT_EQ(device.info().serial, "04D1");
  EXPECT_FALSE(device.info().renders_torque);
  test::Push push;
  device.start(push, test::bareSafety(), Clock::Stepped);
  for (int n = 0; n < 50; ++n) {
    const long before = fake.commands;
    ASSERT_TRUE(device.step());
    ASSERT_TRUE(fake.heard(before + 1)) << "each step has its command, since only commands have replies";
  }
  EXPECT_LT((push.last.handle.position - Eigen::Vector3d(10, 200, 120)).norm(), 1e-9);
  EXPECT_LT((push.last.handle.orientation.vec() - Eigen::Vector3d(0, 0.6, 0)).norm(), 1e-9);
  EXPECT_NEAR(fake.force_x, 1, 1e-5);
  EXPECT_NEAR(fake.force_y, -0.5, 1e-5);
  EXPECT_NEAR(fake.force_z, -2, 1e-5);
  EXPECT_EQ(fake.unmasked, 0);
  const long before_stop = fake.commands;
  device.stop();
  EXPECT_TRUE(fake.heard(before_stop + 3));
  EXPECT_EQ(std::hypot(fake.force_x.load(), fake.force_y.load(), fake.force_z.load()), 0);
}

TEST(HaplyDevice, StreamsMayBeCutAnywhere) {
  for (const FakeHaply::Mode mode : {FakeHaply::kSplit, FakeHaply::kFragments, FakeHaply::kPing, FakeHaply::kNoGrip}) {
    FakeHaply fake;
    fake.mode = mode;
    LinkedDevice device(std::make_unique<test::SteppedLink>(linkTo(fake)));
    test::Push push;
    SafetySettings patient = test::bareSafety();
    patient.off_after = patient.stale_after = 1e6;  // this test counts steps, not milliseconds
    device.start(push, patient, Clock::Stepped);
    for (int n = 0; n < 2000 && push.last.handle.position.x() < 20; ++n) {
      fake.x = 1e-3 * std::min(n, 25);
      device.step();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_GE(push.last.handle.position.x(), 20) << mode;
    EXPECT_EQ(device.status().phase, Phase::Running) << mode;
    EXPECT_EQ(fake.pongs > 0, mode == FakeHaply::kPing || mode == FakeHaply::kFragments) << mode;
  }
}

TEST(HaplyDevice, AServiceThatFallsSilentFadesAndIsOff) {
  for (const FakeHaply::Mode mode : {FakeHaply::kDrop, FakeHaply::kWrongDevice, FakeHaply::kGarbage}) {
    FakeHaply fake;
    LinkedDevice device(std::make_unique<test::SteppedLink>(linkTo(fake)));
    test::Push push;
    device.start(push, test::bareSafety(), Clock::Stepped);
    for (int n = 0; n < 20; ++n) device.step();
    fake.mode = mode;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    for (int n = 0; n < 3; ++n) device.step();  // replies that were on the way
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
    std::vector<double> ages;
    for (int n = 0; n < 250; ++n) {
      device.step();
      ages.push_back(push.last.age);
    }
    EXPECT_TRUE(device.status().safety & kForcesOff) << mode;
    EXPECT_GT(ages.back(), 0.2);
    EXPECT_EQ(device.status().phase, Phase::Running);
    const long sent = fake.commands;
    fake.mode = FakeHaply::kGood;
    for (int n = 0; n < 500 && push.last.age > 0.001; ++n) {
      device.step();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_LE(push.last.age, 0.001) << "it recovers";
    EXPECT_TRUE(fake.heard(sent));
    EXPECT_TRUE(device.status().safety & kForcesOff) << "but forces wait for rearm()";
    EXPECT_LE(fake.largest, 3);
  }
}

TEST(HaplyDevice, ABrokenConnectionIsZeroForGood) {
  for (const FakeHaply::Mode mode : {FakeHaply::kHuge, FakeHaply::kClose, FakeHaply::kMasked}) {
    FakeHaply fake;
    std::vector<Wrench> sent;
    sent.reserve(10'000);
    LinkedDevice device(std::make_unique<test::SteppedLink>(linkTo(fake), &sent));
    test::Push push;
    device.start(push, test::bareSafety(), Clock::Stepped);
    for (int n = 0; n < 20; ++n) device.step();
    EXPECT_GT(sent.back().force.norm(), 1);
    fake.mode = mode;
    for (int n = 0; n < 2000 && device.step(); ++n) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    const DeviceStatus status = device.status();
    EXPECT_EQ(status.phase, Phase::Failed) << mode;
    EXPECT_EQ(status.fault, DeviceFault::Communication);
    EXPECT_NE(status.vendor_code, 0);
    for (std::size_t n = sent.size() - 3; n < sent.size(); ++n) EXPECT_EQ(sent[n].force.norm(), 0);
    device.stop();
    failureTo([&] { device.start(push, test::bareSafety(), Clock::Stepped); }, DeviceFault::Communication);
  }
}

TEST(HaplyDevice, NotANumberIsABadPose) {
  FakeHaply fake;
  LinkedDevice device(std::make_unique<test::SteppedLink>(linkTo(fake)));
  test::Push push;
  device.start(push, test::bareSafety(), Clock::Stepped);
  for (int n = 0; n < 20; ++n) device.step();
  fake.mode = FakeHaply::kNan;
  for (int n = 0; n < 1000 && push.last.handle.position.allFinite(); ++n) {
    device.step();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_FALSE(push.last.handle.position.allFinite());
  EXPECT_TRUE(device.status().safety & kBadPose);
}

TEST(HaplyDevice, NoStepAllocates) {
  FakeHaply fake;
  LinkedDevice device(std::make_unique<test::SteppedLink>(linkTo(fake)));
  test::Push push;
  device.start(push, SafetySettings(), Clock::Stepped);
  for (int n = 0; n < 100; ++n) device.step();
  EXPECT_EQ(spheretree::test::allocationsIn([&] {
              for (int n = 0; n < 5000; ++n) device.step();
            }),
            0);
}

TEST(HaplyDevice, SaysWhatIsWrong) {
  OpenSettings settings;
  settings.haply_host = "127.0.0.1:1";
  EXPECT_NE(failureTo([&] { openDevice("haply", settings); }, DeviceFault::NotFound).find("Start the Haply Inverse Service"),
            std::string::npos);
  settings.haply_host = "10.1.2.3:10001";
  EXPECT_NE(failureTo([&] { openDevice("haply", settings); }, DeviceFault::Refused).find("--allow-remote"), std::string::npos);
  for (const char* bad : {"127.0.0.1", "127.0.0.1:0", "127.0.0.1:70000", ":10001", "127.0.0.1:http"}) {
    settings.haply_host = bad;
    EXPECT_NE(failureTo([&] { openDevice("haply", settings); }, DeviceFault::Refused).find("is not HOST:PORT"), std::string::npos) << bad;
  }
  FakeHaply fake;
  settings.haply_host = fake.host();
  settings.haply_device = "FFFF";
  fake.mode = FakeHaply::kGood;
  EXPECT_NE(failureTo([&] { openDevice("haply", settings); }, DeviceFault::NotFound).find("no Inverse3 'FFFF', but '04D1'"),
            std::string::npos);
  fake.mode = FakeHaply::kNotWebSocket;
  EXPECT_NE(failureTo([&] { openDevice("haply", settings); }, DeviceFault::NotFound).find("check the port"), std::string::npos);
  failureTo([&] { openDevice("novint", settings); }, DeviceFault::Refused);
}

}  // namespace
}  // namespace spheretree::device

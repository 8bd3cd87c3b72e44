// SPDX-License-Identifier: Apache-2.0
#include "links/net_link.h"

#include <gtest/gtest.h>

#include <cstring>
#include <future>
#include <thread>

#include "links/net_address.h"
#include "spheretree/device/device_server.h"
#include "spheretree/device/open_device.h"
#include "spheretree/device/simulated_device.h"
#include "stepped_link.h"
#include "support/allocations_in.h"
#include "support/random.h"

namespace spheretree::device {
namespace {

/// A simulated device, served in lock step to a device in the same test: messages on this machine arrive at once.
struct NetDevice : testing::Test {
  SimulatedDevice served{SimulatedSettings{.path = [](double t) { return Configuration{{5 * t, 0, 0}, {1, 0, 0, 0}}; }}};
  DeviceServer server{0, false, served.info()};
  test::Push push;
  std::vector<Wrench> sent;
  std::unique_ptr<LinkedDevice> client;

  NetDevice() {
    served.start(server, test::bareSafety(), Clock::Stepped);
    client = connect();
  }
  std::string name() const { return "net:127.0.0.1:" + std::to_string(server.port()); }
  std::unique_ptr<LinkedDevice> connect() {
    auto link = std::async(std::launch::async, [&] {
      return std::make_unique<NetLink>(addressOf("127.0.0.1:" + std::to_string(server.port()), false, name()), name());
    });
    while (link.wait_for(std::chrono::milliseconds(1)) != std::future_status::ready) served.step();
    sent.reserve(10'000);
    return std::make_unique<LinkedDevice>(std::make_unique<test::SteppedLink>(link.get(), &sent));
  }
  void both(int steps) {
    for (int n = 0; n < steps; ++n) {
      served.step();
      client->step();
    }
  }
};

TEST_F(NetDevice, PosesComeAndForcesGo) {
  EXPECT_TRUE(client->info().renders_torque);
  push.wrench = {{0.5, 0, 0}, {0, 2, 0}};
  client->start(push, test::bareSafety(), Clock::Stepped);
  both(100);
  EXPECT_NEAR(push.last.handle.position.x(), served.truePose().position.x(), 0.03) << "one count of the encoder";
  EXPECT_NEAR(served.actuated().force.x(), 0.5, 1e-3);
  EXPECT_NEAR(served.actuated().torque.y(), 2, 0.02);
  client->stop();
  both(1);
  served.step();
  EXPECT_EQ(served.actuated().force.norm(), 0);
  EXPECT_TRUE(server.hasClient());
}

TEST_F(NetDevice, AClientThatIsGoneSwitchesTheForcesOff) {
  client->start(push, test::bareSafety(), Clock::Stepped);
  both(100);
  EXPECT_GT(served.actuated().force.norm(), 1);
  for (int n = 0; n < 130; ++n) served.step();
  EXPECT_EQ(served.actuated().force.norm(), 0) << "faded";
  both(1);
  EXPECT_LT(served.actuated().force.norm(), 0.1) << "no kick on return";
  for (int n = 0; n < 250; ++n) served.step();
  EXPECT_TRUE(served.status().safety & kForcesOff);
  EXPECT_FALSE(server.hasClient());
  // Another one may take the device; the forces return when the owner of the device arms it.
  client = connect();
  EXPECT_TRUE(server.hasClient());
  client->start(push, test::bareSafety(), Clock::Stepped);
  both(50);
  EXPECT_EQ(served.actuated().force.norm(), 0);
  served.rearm();
  both(50);
  EXPECT_EQ(served.actuated().force.norm(), 0) << "the guard waits for a wrench near zero";
  push.wrench = {};
  both(10);
  push.wrench.force = {1, 0, 0};
  both(1000);
  EXPECT_NEAR(served.actuated().force.x(), 0.5, 0.02) << "half of the ramp";
}

TEST_F(NetDevice, AServerThatIsGoneFadesTheForces) {
  client->start(push, test::bareSafety(), Clock::Stepped);
  both(50);
  EXPECT_GT(sent.back().force.norm(), 1);
  for (int n = 0; n < 130; ++n) client->step();
  EXPECT_EQ(sent.back().force.norm(), 0);
  for (int n = 0; n < 100; ++n) client->step();
  EXPECT_TRUE(client->status().safety & kForcesOff);
}

TEST_F(NetDevice, StrangersAndOldMessagesAreNotHeard) {
  client->start(push, test::bareSafety(), Clock::Stepped);
  both(50);
  Socket stranger(Socket::Kind::Datagrams);
  const SocketAddress to{kThisHost, server.port()};
  NetPacket packet;
  packet.kind = NetPacket::kWrench;
  packet.sequence = 1'000'000;
  packet.wrench.force = {0, 0, 7};
  spheretree::test::Random random(3);
  const double before = served.actuated().force.z();
  for (int n = 0; n < 500; ++n) {
    auto bytes = encoded(packet);
    std::size_t size = bytes.size();
    if (n % 3 == 1) bytes[random.below(kNetBytes)] ^= std::byte{1};
    if (n % 3 == 2) size = random.below(kNetBytes);
    stranger.sendTo({reinterpret_cast<const char*>(bytes.data()), size}, to);
    both(1);
    ASSERT_NEAR(served.actuated().force.z(), before, 1e-3) << n;
  }
}

/// Every number of a well-formed message may be anything. SPHERETREE_LONG=1: 10^7.
TEST_F(NetDevice, NoMessageSendsMoreThanTheLimitsOrAllocates) {
  spheretree::test::Random random(9);
  client->start(push, test::bareSafety(), Clock::Stepped);
  both(50);
  client.reset();
  for (int n = 0; n < 300; ++n) served.step();
  NetSocket hostile({}, false);
  const SocketAddress to{kThisHost, server.port()};
  const auto number = [&](double scale) {
    float wild = 0;
    const std::uint32_t bits = static_cast<std::uint32_t>(random.below(1u << 31)) * 2;
    std::memcpy(&wild, &bits, sizeof wild);
    return random.below(100) > 0 ? random.between(-scale, scale) : static_cast<double>(wild);
  };
  const long count = std::getenv("SPHERETREE_LONG") ? 10'000'000 : 100'000;
  double largest = 0;
  NetPacket packet;
  packet.kind = NetPacket::kWrench;
  for (int n = 0; n < 20; ++n) {  // it is gentle first, so that the guard lets it through
    ++packet.sequence;
    hostile.send(packet, to);
    served.rearm();
    served.step();
  }
  EXPECT_EQ(spheretree::test::allocationsIn([&] {
              for (long n = 0; n < count; ++n) {
                packet.sequence += random.below(20) == 0 ? -3 : 1;
                packet.wrench = {{number(10), number(10), number(10)}, {number(200), number(200), number(200)}};
                hostile.send(packet, to);
                if (random.below(50) == 0) served.rearm();
                served.step();
                const double force = served.actuated().force.norm();
                if (!(force <= largest)) largest = force;
              }
            }),
            0);
  EXPECT_LE(largest, 8 * (1 + 1e-3)) << "16 bits of a command";
  EXPECT_GT(largest, 7) << "the test looks away";
}

TEST(NetDeviceName, RefusesOtherMachinesAndSaysWhoIsMissing) {
  const auto failure = [](const std::string& name, bool remote) -> DeviceError {
    OpenSettings settings;
    settings.allow_remote = remote;
    try {
      openDevice(name, settings);
    } catch (const DeviceError& error) {
      return error;
    }
    return {DeviceFault::None, "it opened"};
  };
  EXPECT_EQ(failure("net:192.168.1.20:47000", false).fault, DeviceFault::Refused);
  EXPECT_EQ(failure("net:127.0.0.1", false).fault, DeviceFault::Refused);
  const DeviceError silent = failure("net:127.0.0.1:9", false);
  EXPECT_EQ(silent.fault, DeviceFault::NotFound);
  EXPECT_NE(std::string(silent.what()).find("--serve"), std::string::npos);
  const SimulatedDevice device({});
  const DeviceServer first(0, false, device.info());
  EXPECT_THROW(DeviceServer(first.port(), false, device.info()), DeviceError);
}

}  // namespace
}  // namespace spheretree::device

// SPDX-License-Identifier: Apache-2.0
// Two sockets of this machine. Subject: sockets.h
#include "system/sockets.h"

#include <gtest/gtest.h>

#include <array>
#include <chrono>
#include <string>
#include <string_view>

#include "spheretree/device/device.h"

namespace spheretree::device {
namespace {

constexpr std::chrono::milliseconds kPatience{2000}, kNone{0};

std::span<const char> bytesOf(std::string_view text) { return {text.data(), text.size()}; }

struct Bound {
  Socket socket{Socket::Kind::Datagrams};
  Bound() { EXPECT_EQ(socket.bind({kThisHost, 0}), 0); }
};

TEST(Sockets, MessagesKeepTheirBoundsAndSender) {
  Bound a, b;
  EXPECT_NE(a.socket.ownAddress().port, 0);
  std::array<char, 8> space{};
  SocketAddress from;
  EXPECT_FALSE(b.socket.waitForData(kNone));
  EXPECT_EQ(b.socket.receiveFrom(space, from).error, kWouldWait);
  for (const char* text : {"one", "three"}) EXPECT_EQ(a.socket.sendTo(bytesOf(text), b.socket.ownAddress()).error, 0);
  for (const std::string_view text : {"one", "three"}) {
    ASSERT_TRUE(b.socket.waitForData(kPatience));
    const Transfer got = b.socket.receiveFrom(space, from);
    EXPECT_EQ(std::string_view(space.data(), got.bytes), text);
    EXPECT_EQ(from, a.socket.ownAddress());
  }
}

TEST(Sockets, AMessageThatIsTooLongIsCutOff) {
  Bound a, b;
  std::array<char, 4> space{};
  SocketAddress from;
  for (const char* text : {"too long", "next"}) a.socket.sendTo(bytesOf(text), b.socket.ownAddress());
  for (const std::string_view text : {"too ", "next"}) {
    ASSERT_TRUE(b.socket.waitForData(kPatience));
    const Transfer got = b.socket.receiveFrom(space, from);
    EXPECT_EQ(got.error, 0);
    EXPECT_EQ(std::string_view(space.data(), got.bytes), text);
  }
}

TEST(Sockets, APortBelongsToOne) {
  Bound a;
  Socket other(Socket::Kind::Datagrams);
  const int error = other.bind(a.socket.ownAddress());
  EXPECT_NE(error, 0);
  EXPECT_FALSE(socketWords(error).empty());
}

// The port was free a moment ago: nobody listens.
TEST(Sockets, AConnectionThatNobodyAcceptsFails) {
  std::uint16_t port = 0;
  {
    Socket before(Socket::Kind::Stream);
    ASSERT_EQ(before.bind({kThisHost, 0}), 0);
    port = before.ownAddress().port;
  }
  Socket socket(Socket::Kind::Stream);
  EXPECT_NE(socket.connect({kThisHost, port}, kPatience), 0);
}

TEST(Sockets, HostsAreFoundByNameOrNumber) {
  std::string why;
  EXPECT_EQ(findHost("127.0.0.1", why), kThisHost);
  EXPECT_EQ(findHost("localhost", why), kThisHost);
  EXPECT_TRUE(why.empty());
  EXPECT_EQ(findHost("no host has this name", why), std::nullopt);
  EXPECT_FALSE(why.empty());
}

}  // namespace
}  // namespace spheretree::device

// SPDX-License-Identifier: Apache-2.0
#include "links/net_packet.h"

#include <gtest/gtest.h>

#include <cstring>
#include <optional>
#include <span>

namespace spheretree::device {
namespace {

TEST(NetPacket, IsTheTableOfTheDocument) {
  NetPacket packet;
  packet.kind = NetPacket::kWrench;
  packet.flags = 4;
  packet.buttons = 9;
  packet.temperature = 0.5f;
  packet.sequence = 7;
  packet.echo = 6;
  packet.pose = {{1, 2, 3}, {0.5, -0.5, 0.5, -0.5}};
  packet.wrench = {{4, 5, 6}, {7, 8, 9}};
  const auto bytes = encoded(packet);
  EXPECT_EQ(std::memcmp(bytes.data(), "STD1", 4), 0);
  const auto floatAt = [&](std::size_t at) {
    float value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  };
  EXPECT_EQ(floatAt(12), 0.5f);
  EXPECT_EQ(std::to_integer<int>(bytes[16]), 7);
  EXPECT_EQ(std::to_integer<int>(bytes[32]), 6);
  EXPECT_EQ(floatAt(40), 1.0f);
  EXPECT_EQ(floatAt(52), 0.5f);
  EXPECT_EQ(floatAt(68), 4.0f);
  EXPECT_EQ(floatAt(88), 9.0f);
  const std::optional<NetPacket> back = decoded(bytes);
  ASSERT_TRUE(back);
  EXPECT_EQ(encoded(*back), bytes);
}

TEST(NetPacket, NothingElseIsTakenForOne) {
  const auto bytes = encoded(NetPacket());
  EXPECT_TRUE(decoded(bytes));
  EXPECT_FALSE(decoded(std::span(bytes).first(kNetBytes - 1)));
  for (std::size_t n = 0; n < kNetBytes; ++n)
    for (int bit = 0; bit < 8; ++bit) {
      auto changed = bytes;
      changed[n] ^= std::byte{1} << bit;
      EXPECT_FALSE(decoded(changed)) << n;
    }
  NetPacket other;
  other.kind = 3;
  EXPECT_FALSE(decoded(encoded(other)));
}

}  // namespace
}  // namespace spheretree::device

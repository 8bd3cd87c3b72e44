// SPDX-License-Identifier: Apache-2.0
#include "links/net_address.h"

#include <gtest/gtest.h>

#include <string>

#include "spheretree/device/device.h"

namespace spheretree::device {
namespace {

DeviceFault faultOf(const std::string& text, bool allow_remote = false) {
  try {
    addressOf(text, allow_remote, "test");
  } catch (const DeviceError& error) {
    return error.fault;
  }
  return DeviceFault::None;
}

TEST(NetAddress, APortIsAWholeNumberUpTo65535) {
  EXPECT_EQ(portOf("1"), 1);
  EXPECT_EQ(portOf("65535"), 65535);
  for (const char* text : {"", "0", "65536", "99999999999", "-1", "+1", " 1", "1 ", "1.5", "http", "0x10"})
    EXPECT_EQ(portOf(text), 0) << text;
}

TEST(NetAddress, IsHostAndPort) {
  const SocketAddress address = addressOf("127.0.0.1:47000", false, "test");
  EXPECT_EQ(address.port, 47000);
  EXPECT_EQ(address.host, kThisHost);
  for (const char* text : {"", ":", "127.0.0.1", "127.0.0.1:", ":47000", "127.0.0.1:0", "127.0.0.1:70000", "127.0.0.1:47000x"})
    EXPECT_EQ(faultOf(text), DeviceFault::Refused) << text;
}

TEST(NetAddress, OtherMachinesNeedLeave) {
  EXPECT_EQ(faultOf("127.255.0.1:1"), DeviceFault::None);
  for (const char* text : {"192.168.1.20:1", "126.255.255.255:1", "128.0.0.0:1", "0.0.0.0:1"}) {
    EXPECT_EQ(faultOf(text), DeviceFault::Refused) << text;
    EXPECT_EQ(faultOf(text, true), DeviceFault::None) << text;
  }
}

}  // namespace
}  // namespace spheretree::device

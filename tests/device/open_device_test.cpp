// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/open_device.h"

#include <gtest/gtest.h>

#include <string>

namespace spheretree::device {
namespace {

TEST(OpenDevice, KnowsTheNamesOfLinksAlone) {
  for (const char* name : {"haply", "dhd", "phantom", "net:127.0.0.1:1"}) EXPECT_TRUE(isDeviceName(name)) << name;
  for (const char* name : {"", "Haply", "net", "simulated", "dhd "}) EXPECT_FALSE(isDeviceName(name)) << name;
}

TEST(OpenDevice, SaysWhichNamesThereAre) {
  try {
    openDevice("touch", {});
    FAIL() << "it opened";
  } catch (const DeviceError& error) {
    EXPECT_EQ(error.fault, DeviceFault::Refused);
    EXPECT_EQ(std::string(error.what()), "there is no device 'touch': give haply, dhd, phantom or net:HOST:PORT");
  }
}

}  // namespace
}  // namespace spheretree::device

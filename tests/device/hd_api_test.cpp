// SPDX-License-Identifier: Apache-2.0
#include "links/hd_api.h"

#include <gtest/gtest.h>

#include "opened_library.h"
#include "spheretree/device/device.h"

namespace spheretree::device {
namespace {

DeviceError failureOf(const std::string& library) {
  try {
    loadHdApi(library);
  } catch (const DeviceError& error) {
    return error;
  }
  return {DeviceFault::None, "it was loaded"};
}

TEST(HdApi, EveryFunctionIsTheLibrarysOwn) {
  const HdApi& api = loadHdApi(FAKE_LIBHD);
  void* library = test::opened(FAKE_LIBHD);
  ASSERT_NE(library, nullptr);
  int functions = 0;
#define SAME(function, ...)                                                                       \
  EXPECT_EQ(reinterpret_cast<void*>(api.function), test::found(library, #function)) << #function; \
  ++functions;
  SPHERETREE_HD_FUNCTIONS(SAME)
#undef SAME
  EXPECT_EQ(functions, 22);
}

TEST(HdApi, ALibraryIsLoadedOnce) {
  EXPECT_EQ(&loadHdApi(FAKE_LIBHD), &loadHdApi(FAKE_LIBHD));
  EXPECT_EQ(failureOf(FAKE_LIBHD_INCOMPLETE).fault, DeviceFault::SymbolMissing);
  EXPECT_TRUE(test::isOpen(FAKE_LIBHD_INCOMPLETE)) << "its driver does not survive a second load";
}

TEST(HdApi, SaysInTheLoadersWordsWhyThereIsNone) {
  const DeviceError error = failureOf("/nowhere/libHD.so");
  EXPECT_EQ(error.fault, DeviceFault::LibraryMissing);
  std::string why;
  EXPECT_EQ(loadLibrary("/nowhere/libHD.so", why), nullptr);
  EXPECT_TRUE(why.starts_with("/nowhere/libHD.so: ") && why.size() > 24) << why;
  EXPECT_NE(std::string(error.what()).find(why), std::string::npos) << error.what();
  const std::string text_file = failureOf(__FILE__).what();
  EXPECT_NE(text_file.find("hd_api_test.cpp"), std::string::npos) << text_file;
  if (test::opened(hdLibraryNames().front())) GTEST_SKIP() << "OpenHaptics is installed here";
  const std::string message = failureOf("").what();
  for (const std::string& name : hdLibraryNames()) EXPECT_NE(message.find(name + ": "), std::string::npos) << message;
}

TEST(HdApi, NamesTheFirstMissingFunction) {
  for (int round = 0; round < 2; ++round) {  // the second time it is loaded already
    const DeviceError error = failureOf(FAKE_LIBHD_INCOMPLETE);
    EXPECT_EQ(error.fault, DeviceFault::SymbolMissing);
    EXPECT_NE(std::string(error.what()).find("hdGetErrorString"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace spheretree::device

// SPDX-License-Identifier: Apache-2.0
#include "hd_api.h"

#include <dlfcn.h>
#include <gtest/gtest.h>

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
  void* library = dlopen(FAKE_LIBHD, RTLD_NOW | RTLD_LOCAL);
  ASSERT_NE(library, nullptr);
  int functions = 0;
#define SAME(function, ...)                                                                 \
  EXPECT_EQ(reinterpret_cast<void*>(api.function), dlsym(library, #function)) << #function; \
  ++functions;
  SPHERETREE_HD_FUNCTIONS(SAME)
#undef SAME
  EXPECT_EQ(functions, 22);
}

TEST(HdApi, ALibraryIsLoadedOnce) {
  EXPECT_EQ(&loadHdApi(FAKE_LIBHD), &loadHdApi(FAKE_LIBHD));
  EXPECT_EQ(failureOf(FAKE_LIBHD_INCOMPLETE).fault, DeviceFault::SymbolMissing);
  EXPECT_NE(dlopen(FAKE_LIBHD_INCOMPLETE, RTLD_NOW | RTLD_NOLOAD), nullptr) << "its driver does not survive a second load";
}

TEST(HdApi, SaysInTheLoadersWordsWhyThereIsNone) {
  const DeviceError error = failureOf("/nowhere/libHD.so");
  EXPECT_EQ(error.fault, DeviceFault::LibraryMissing);
  EXPECT_NE(std::string(error.what()).find("/nowhere/libHD.so: cannot open shared object file: No such file"), std::string::npos)
      << error.what();
  const std::string text_file = failureOf(__FILE__).what();
  EXPECT_NE(text_file.find("hd_api_test.cpp"), std::string::npos) << text_file;
  if (dlopen("libHD.so", RTLD_NOW | RTLD_LOCAL)) GTEST_SKIP() << "OpenHaptics is installed here";
  const std::string message = failureOf("").what();
  for (const char* name : {"libHD.so: ", "libHD.so.3.5: ", "libHD.so.3.4: ", "libHD.so.3.0: "})
    EXPECT_NE(message.find(name), std::string::npos) << message;
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

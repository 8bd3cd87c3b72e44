// SPDX-License-Identifier: Apache-2.0
#include "dhd_api.h"

#include <dlfcn.h>

#include <vector>

#include "spheretree/device/device.h"

namespace spheretree::device {
namespace {

DhdApi resolveDhd(void* library, const std::string& name) {
  DhdApi api;
  const auto find = [&](const char* symbol) {
    if (void* address = dlsym(library, symbol)) return address;
    throw DeviceError(DeviceFault::SymbolMissing,
                      name + " has no function " + symbol + ": it is not the Force Dimension SDK 3, install that version");
  };
#define SPHERETREE_DHD_RESOLVE(function, result, ...) api.function = reinterpret_cast<result (*)(__VA_ARGS__)>(find(#function));
  SPHERETREE_DHD_FUNCTIONS(SPHERETREE_DHD_RESOLVE)
#undef SPHERETREE_DHD_RESOLVE
  return api;
}

}  // namespace

DhdApi loadDhdApi(const std::string& library) {
  // libdrd has the functions of libdhd, too.
  const std::vector<std::string> names = library.empty() ? std::vector<std::string>{"libdhd.so", "libdhd.so.3", "libdrd.so", "libdrd.so.3"}
                                                         : std::vector<std::string>{library};
  std::string tried;
  for (const std::string& name : names) {
    if (void* handle = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL)) return resolveDhd(handle, name);
    const char* why = dlerror();
    tried += (tried.empty() ? "" : "; ") + std::string(why ? why : name + " cannot be loaded");
  }
  throw DeviceError(DeviceFault::LibraryMissing, "no Force Dimension library: " + tried +
                                                     ". Install the Force Dimension SDK, or name its file, such as libdhd.so.3.17.6 "
                                                     "(haptic-player: --dhd-library)");
}

}  // namespace spheretree::device

// SPDX-License-Identifier: Apache-2.0
#include "links/dhd_api.h"

#include <vector>

#include "spheretree/device/device.h"
#include "system/system_calls.h"

namespace spheretree::device {
namespace {

DhdApi resolveDhd(void* library, const std::string& name) {
  DhdApi api;
  const auto find = [&](const char* symbol) {
    std::string why;
    if (void* address = findFunction(library, symbol, why)) return address;
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
  const std::vector<std::string> names = library.empty() ? dhdLibraryNames() : std::vector<std::string>{library};
  std::string tried;
  for (const std::string& name : names) {
    std::string why;
    if (void* handle = loadLibrary(name, why)) return resolveDhd(handle, name);
    tried += (tried.empty() ? "" : "; ") + (why.empty() ? name + " cannot be loaded" : why);
  }
  throw DeviceError(DeviceFault::LibraryMissing, "no Force Dimension library: " + tried +
                                                     ". Install the Force Dimension SDK, or name its file, such as libdhd.so.3.17.6 "
                                                     "(haptic-player: --dhd-library)");
}

}  // namespace spheretree::device

// SPDX-License-Identifier: Apache-2.0
#include "links/hd_api.h"

#include <map>
#include <mutex>
#include <vector>

#include "spheretree/device/device.h"
#include "system/system_calls.h"

namespace spheretree::device {
namespace {

HdApi resolve(void* library, const std::string& name) {
  HdApi api;
  const auto find = [&](const char* symbol) {
    std::string why;
    if (void* address = findFunction(library, symbol, why)) return address;
    throw DeviceError(DeviceFault::SymbolMissing, name + " has no function " + symbol + " (" + (why.empty() ? "null" : why) +
                                                      "): it is not OpenHaptics 3, install that version");
  };
#define SPHERETREE_HD_RESOLVE(function, result, ...) api.function = reinterpret_cast<result (*)(__VA_ARGS__)>(find(#function));
  SPHERETREE_HD_FUNCTIONS(SPHERETREE_HD_RESOLVE)
#undef SPHERETREE_HD_RESOLVE
  return api;
}

}  // namespace

const HdApi& loadHdApi(const std::string& library) {
  static std::mutex mutex;
  static std::map<void*, HdApi> loaded;  // the same library has the same handle
  const std::lock_guard lock(mutex);
  const std::vector<std::string> names = library.empty() ? hdLibraryNames() : std::vector<std::string>{library};
  std::string tried;
  for (const std::string& name : names) {
    std::string why;
    void* handle = loadLibrary(name, why);
    if (!handle) {
      tried += (tried.empty() ? "" : "; ") + (why.empty() ? name + " cannot be loaded" : why);
      continue;
    }
    if (const auto found = loaded.find(handle); found != loaded.end()) return found->second;
    return loaded.emplace(handle, resolve(handle, name)).first->second;
  }
  throw DeviceError(DeviceFault::LibraryMissing,
                    "no OpenHaptics library: " + tried + ". Install OpenHaptics and the driver of the device, or name the library file");
}

}  // namespace spheretree::device

// SPDX-License-Identifier: Apache-2.0
// A shared library as the devices open it. Null: there is none, or it has no such function.
#pragma once

#ifdef _WIN32
#include <windows.h>
#else
#include <dlfcn.h>
#endif

#include <string>

#include "system/system_calls.h"

namespace spheretree::device::test {

inline void* opened(const std::string& library) {
  std::string why;
  return loadLibrary(library, why);
}

inline void* found(void* library, const char* function) {
  std::string why;
  return findFunction(library, function, why);
}

inline bool isOpen(const std::string& library) {
#ifdef _WIN32
  return ::GetModuleHandleA(library.c_str()) != nullptr;
#else
  return dlopen(library.c_str(), RTLD_NOW | RTLD_NOLOAD) != nullptr;
#endif
}

}  // namespace spheretree::device::test

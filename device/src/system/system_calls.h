// SPDX-License-Identifier: Apache-2.0
// What devices ask of the system: system_calls_posix.cpp and system_calls_windows.cpp.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

namespace spheretree::device {

/// Sleeps until the steady clock (std::chrono::steady_clock) is at `ns`, more precisely than std::this_thread does on
/// every system.
void sleepUntil(std::int64_t ns) noexcept;

/// The names that the vendors' libraries may have where the loader looks.
std::vector<std::string> hdLibraryNames();
std::vector<std::string> dhdLibraryNames();  // also libdrd, which has the functions of libdhd

/// Loads a shared library, which stays loaded; the same library has the same handle. Null with the loader's words in
/// `why`.
void* loadLibrary(const std::string& name, std::string& why);
/// Null with the loader's words in `why`.
void* findFunction(void* library, const char* name, std::string& why);

/// Calls `handler` for the signals that end a program, until it is destroyed; then their former handlers are back.
class EndingSignals {
 public:
  explicit EndingSignals(void (*handler)(int));
  ~EndingSignals();
  EndingSignals(const EndingSignals&) = delete;
  EndingSignals& operator=(const EndingSignals&) = delete;

 private:
  struct Former;
  std::unique_ptr<Former> former_;
};

}  // namespace spheretree::device

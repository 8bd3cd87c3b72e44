// SPDX-License-Identifier: GPL-3.0-or-later
#include <windows.h>
// After windows.h:
#include <psapi.h>

#include <chrono>
#include <system_error>

#include "run/real_time.h"

namespace spheretree::player {
namespace {

std::string words(DWORD error) { return std::system_category().message(static_cast<int>(error)); }

}  // namespace

std::string priorityAdvice(int error) {
  return "no real-time priority (" + words(static_cast<DWORD>(error)) + "): other programs may delay a step. Close them.";
}

std::string lockMemory() {  // a smallest working set that holds what the process has now
  constexpr SIZE_T kSpare = 64 << 20;
  PROCESS_MEMORY_COUNTERS memory{};
  memory.cb = sizeof memory;
  const HANDLE process = ::GetCurrentProcess();
  if (::GetProcessMemoryInfo(process, &memory, sizeof memory) &&
      ::SetProcessWorkingSetSizeEx(process, memory.WorkingSetSize, memory.WorkingSetSize + kSpare,
                                   QUOTA_LIMITS_HARDWS_MIN_ENABLE | QUOTA_LIMITS_HARDWS_MAX_DISABLE))
    return {};
  return "memory is not locked (" + words(::GetLastError()) + "): a step may wait for the disk. Close other programs.";
}

double threadTime() noexcept {
  // Windows counts the time of a thread in ticks of 15.6 ms: the clock tells more.
  return std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace spheretree::player

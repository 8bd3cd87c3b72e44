// SPDX-License-Identifier: Apache-2.0
#include <windows.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "spheretree/device/real_time_thread.h"
#include "system/system_calls.h"

namespace spheretree::device {
namespace {

// SIGBREAK: Ctrl-Break, a window of the console that is closed, and the end of the session.
constexpr int kEndingSignals[] = {SIGINT, SIGTERM, SIGBREAK};

std::atomic<void (*)(int)> ending_handler{nullptr};

/// The system takes a handler away before it calls it, and calls it in a thread of its own. When it returns after
/// SIGBREAK, the program is ended: until then the servo thread needs a few steps to take off the forces.
extern "C" void onEndingSignal(int number) {
  std::signal(number, onEndingSignal);
  if (void (*const handler)(int) = ending_handler.load()) handler(number);
  if (number == SIGBREAK) ::Sleep(100);
}

std::string loadersWords() { return std::system_category().message(static_cast<int>(::GetLastError())); }

constexpr DWORD kHighResolution = 2;  // CREATE_WAITABLE_TIMER_HIGH_RESOLUTION, which the headers of mingw-w64 do not have

/// Ordinary timers of Windows wait for the next tick of 15.6 ms.
class PreciseTimer {
 public:
  PreciseTimer() : timer_(::CreateWaitableTimerExW(nullptr, nullptr, kHighResolution, TIMER_ALL_ACCESS)) {}
  ~PreciseTimer() {
    if (timer_) ::CloseHandle(timer_);
  }
  PreciseTimer(const PreciseTimer&) = delete;
  PreciseTimer& operator=(const PreciseTimer&) = delete;
  bool sleep(std::int64_t ns) noexcept {
    LARGE_INTEGER due;
    due.QuadPart = -(ns + 99) / 100;  // negative: from now, in units of 100 ns
    return timer_ && ::SetWaitableTimer(timer_, &due, 0, nullptr, nullptr, FALSE) &&
           ::WaitForSingleObject(timer_, INFINITE) == WAIT_OBJECT_0;
  }

 private:
  HANDLE timer_;
};

}  // namespace

void sleepUntil(std::int64_t ns) noexcept {
  thread_local PreciseTimer timer;
  for (;;) {
    const std::int64_t left = ns - std::chrono::steady_clock::now().time_since_epoch() / std::chrono::nanoseconds(1);
    if (left <= 0) return;
    if (!timer.sleep(left)) ::Sleep(1);
  }
}

int requestRealTimeThread() noexcept {
  return ::SetThreadPriority(::GetCurrentThread(), THREAD_PRIORITY_TIME_CRITICAL) ? 0 : static_cast<int>(::GetLastError());
}

std::vector<std::string> hdLibraryNames() { return {"hd.dll"}; }

std::vector<std::string> dhdLibraryNames() { return {"dhd64.dll", "drd64.dll"}; }

void* loadLibrary(const std::string& name, std::string& why) {
  void* const library = ::LoadLibraryW(std::filesystem::path(std::u8string(name.begin(), name.end())).c_str());
  if (!library) why = name + ": " + loadersWords();
  return library;
}

void* findFunction(void* library, const char* name, std::string& why) {
  void* const address = reinterpret_cast<void*>(::GetProcAddress(static_cast<HMODULE>(library), name));
  if (!address) why = loadersWords();
  return address;
}

struct EndingSignals::Former {
  void (*actions[std::size(kEndingSignals)])(int);
  void (*handler)(int);
};

EndingSignals::EndingSignals(void (*handler)(int)) : former_(std::make_unique<Former>()) {
  former_->handler = ending_handler.exchange(handler);
  for (std::size_t k = 0; k < std::size(kEndingSignals); ++k) former_->actions[k] = std::signal(kEndingSignals[k], onEndingSignal);
}

EndingSignals::~EndingSignals() {
  for (std::size_t k = 0; k < std::size(kEndingSignals); ++k) std::signal(kEndingSignals[k], former_->actions[k]);
  ending_handler.store(former_->handler);
}

}  // namespace spheretree::device

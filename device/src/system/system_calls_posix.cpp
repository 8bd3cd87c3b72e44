// SPDX-License-Identifier: Apache-2.0
#include <dlfcn.h>
#include <pthread.h>
#include <sched.h>

#include <cerrno>
#include <csignal>
#include <ctime>

#include "spheretree/device/real_time_thread.h"
#include "system/system_calls.h"

namespace spheretree::device {
namespace {

constexpr int kEndingSignals[] = {SIGINT, SIGTERM, SIGHUP};

std::string loadersWords() {
  const char* words = dlerror();
  return words ? words : "";
}

}  // namespace

void sleepUntil(std::int64_t ns) noexcept {  // the steady clock of libstdc++ is CLOCK_MONOTONIC
  const timespec at{static_cast<time_t>(ns / 1'000'000'000), static_cast<long>(ns % 1'000'000'000)};
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) {
  }
}

int requestRealTimeThread() noexcept {
  sched_param priority{};
  priority.sched_priority = 80;  // above ordinary programs, below the kernel's own threads
  return ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
}

std::vector<std::string> hdLibraryNames() { return {"libHD.so", "libHD.so.3.5", "libHD.so.3.4", "libHD.so.3.0"}; }

std::vector<std::string> dhdLibraryNames() { return {"libdhd.so", "libdhd.so.3", "libdrd.so", "libdrd.so.3"}; }

void* loadLibrary(const std::string& name, std::string& why) {
  void* const library = dlopen(name.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library) why = loadersWords();
  return library;
}

void* findFunction(void* library, const char* name, std::string& why) {
  dlerror();
  void* const address = dlsym(library, name);
  if (!address) why = loadersWords();
  return address;
}

struct EndingSignals::Former {
  struct sigaction actions[std::size(kEndingSignals)];
};

EndingSignals::EndingSignals(void (*handler)(int)) : former_(std::make_unique<Former>()) {
  struct sigaction action = {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  for (std::size_t k = 0; k < std::size(kEndingSignals); ++k) sigaction(kEndingSignals[k], &action, &former_->actions[k]);
}

EndingSignals::~EndingSignals() {
  for (std::size_t k = 0; k < std::size(kEndingSignals); ++k) sigaction(kEndingSignals[k], &former_->actions[k], nullptr);
}

}  // namespace spheretree::device

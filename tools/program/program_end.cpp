// SPDX-License-Identifier: GPL-3.0-or-later
#include "program_end.h"

#include <time.h>

#include <atomic>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <exception>
#include <iostream>
#include <new>

#include "spheretree/builder/build_settings.h"
#include "spheretree/formats/errors.h"
#include "system_calls.h"
#include "terminal.h"

namespace spheretree::tool {
namespace {

std::atomic<builder::Progress*> running{nullptr};
static_assert(std::atomic<builder::Progress*>::is_always_lock_free, "a signal handler may not wait");

constexpr std::int64_t kSameInterrupt = 300'000'000;  // ns; two signals this close are one: `timeout` sends its own to the group, too
std::atomic<std::int64_t> interrupted_at{0};          // ns of the monotonic clock; 0: not yet
static_assert(std::atomic<std::int64_t>::is_always_lock_free);

std::int64_t nanoseconds() {
  timespec now{};
  ::clock_gettime(CLOCK_MONOTONIC, &now);
  return 1'000'000'000 * std::int64_t{now.tv_sec} + now.tv_nsec;
}

// Only calls that a signal handler may make.
extern "C" void interrupt(int signal) {
  const std::int64_t now = nanoseconds();
  std::int64_t first = 0;
  if (interrupted_at.compare_exchange_strong(first, now)) {
    if (builder::Progress* progress = running.load()) progress->cancel();
  } else if (now - first > kSameInterrupt) {
    std::signal(signal, SIG_DFL);
    std::raise(signal);  // delivered when the handler returns
  }
}

/// A full disk or a closed pipe is only noticed when the buffer is written.
int flushed(const std::string& program, int code) {
  if (std::cout.flush() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0) return code;
  if (readerHasGone()) return kExitFile;  // nobody would read a message
  return explain(program, kExitFile, "standard output: cannot be written. Free some space or write elsewhere.");
}

}  // namespace

InterruptGuard::InterruptGuard(builder::Progress& progress) {
  running.store(&progress);
  interrupted_at.store(0);
  catchInterrupts(interrupt);
}

InterruptGuard::~InterruptGuard() {
  running.store(nullptr);
  if (interrupted_at.load() != 0) return;  // the program ends: the rest of the same interrupt must not cut off its message
  releaseInterrupts(interrupt);
}

int explain(const std::string& program, int code, const std::string& message) {
  const bool is_sentence = message.ends_with('.') || message.ends_with('!') || message.ends_with('?');
  say(program + ": " + message + (is_sentence ? "" : "."));
  return code;
}

int runAndExplain(const std::string& program, const std::function<int()>& run) {
  prepareStreams();
  try {
    return flushed(program, run());
  } catch (const UsageError& error) {
    return explain(program, kExitUsage, error.what());
  } catch (const formats::FileError& error) {
    return explain(program, kExitFile, error.what());
  } catch (const formats::FormatError& error) {
    return explain(program, kExitRefused, error.what());
  } catch (const builder::BuildError& error) {
    return explain(program, kExitRefused, error.what());
  } catch (const builder::Cancelled&) {
    return explain(program, kExitInterrupted, "interrupted, nothing was written.");
  } catch (const std::bad_alloc&) {
    return explain(program, kExitInternal, "not enough memory. Close other programs or use a smaller input.");
  } catch (const std::exception& error) {
    std::string message = "internal error: ";
    message.append(error.what()).append(". Please report this with the command and its input.");
    return explain(program, kExitInternal, message);
  }
}

}  // namespace spheretree::tool

// SPDX-License-Identifier: GPL-3.0-or-later
#include <sys/mman.h>
#include <time.h>

#include <cerrno>
#include <cstring>

#include "run/real_time.h"

namespace spheretree::player {

std::string priorityAdvice(int error) {
  return std::string("no real-time priority (") + std::strerror(error) + "): other programs may delay a step. Raise `ulimit -r` to 80.";
}

std::string lockMemory() {
  if (::mlockall(MCL_CURRENT | MCL_FUTURE) == 0) return {};
  return std::string("memory is not locked (") + std::strerror(errno) + "): a step may wait for the disk. Raise `ulimit -l`.";
}

double threadTime() noexcept {
  timespec t{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

}  // namespace spheretree::player

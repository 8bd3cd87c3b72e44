// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/real_time_thread.h"

#include <pthread.h>
#include <sched.h>

namespace spheretree::device {

int requestRealTimeThread() noexcept {
  sched_param priority{};
  priority.sched_priority = 80;  // above ordinary programs, below the kernel's own threads
  return ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &priority);
}

}  // namespace spheretree::device

// SPDX-License-Identifier: GPL-3.0-or-later
// The number of threads to start where a caller asks for a number.
#pragma once

#include <tbb/info.h>

#include <algorithm>

namespace spheretree::builder {

/// Results do not depend on the number of threads. With hundreds of threads for each processor, all of them look for
/// work most of the time.
inline constexpr int kThreadsOfProcessor = 4;

/// `wanted`, or the number beyond which more threads only cost time; 0: one for each processor.
inline int usefulThreads(int wanted) {
  const int processors = tbb::info::default_concurrency();
  return wanted > 0 ? std::min(wanted, kThreadsOfProcessor * processors) : processors;
}

}  // namespace spheretree::builder

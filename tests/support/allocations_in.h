// SPDX-License-Identifier: Apache-2.0
// Counts allocations, in a program of which one source includes count_allocations.h.
#pragma once

namespace spheretree::test {

inline thread_local long allocations = 0;  // of this thread so far

/// Number of allocations of this thread in `work`.
template <class Work>
long allocationsIn(const Work& work) {
  const long before = allocations;
  work();
  return allocations - before;
}

}  // namespace spheretree::test

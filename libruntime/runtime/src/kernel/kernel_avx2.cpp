// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx2 -mno-fma; called only on machines with AVX2.
#include <cpuid.h>

#include "kernel/kernel_lanes.h"

namespace spheretree::runtime {

namespace {

// Intel 64 and IA-32 architectures software developer's manual, volume 1, 14.7.1. The compiler's built-in test adds 4
// KiB to the library.
bool hasAvx2() {
  unsigned a = 0, b = 0, c = 0, d = 0;
  constexpr unsigned kOsSavesAndAvx = (1u << 27) | (1u << 28), kAvx2 = 1u << 5;
  if (!__get_cpuid(1, &a, &b, &c, &d) || (c & kOsSavesAndAvx) != kOsSavesAndAvx) return false;
  unsigned saved = 0, high = 0;
  __asm__("xgetbv" : "=a"(saved), "=d"(high) : "c"(0));
  return (saved & 6) == 6 && __get_cpuid_count(7, 0, &a, &b, &c, &d) && (b & kAvx2) != 0;
}

}  // namespace

const KernelTable* avx2Kernel() { return hasAvx2() ? &kTable : nullptr; }

}  // namespace spheretree::runtime

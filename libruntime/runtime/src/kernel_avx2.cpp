// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx2 -mno-fma; reached only on machines that have AVX2.
#include "kernel_lanes.h"

namespace spheretree::runtime {

const KernelTable* avx2Kernel() { return __builtin_cpu_supports("avx2") ? &kTable : nullptr; }

}  // namespace spheretree::runtime

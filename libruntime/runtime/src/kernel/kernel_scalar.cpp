// SPDX-License-Identifier: Apache-2.0
// The reference implementation: the base instruction set of the machine.
#include "kernel/kernel_lanes.h"

namespace spheretree::runtime {

const KernelTable& scalarKernel() { return kTable; }

#if !defined(__x86_64__)
const KernelTable* avx2Kernel() { return nullptr; }
#endif

}  // namespace spheretree::runtime

// SPDX-License-Identifier: Apache-2.0
#include "cut/cut_kernel_lanes.h"

namespace spheretree::runtime {

const CutKernel& scalarCutKernel() {
  static constexpr CutKernel kernel{cutBlock, nearWalls, signedDistances};
  return kernel;
}

#if !defined(__x86_64__)
const CutKernel& avx2CutKernel() { return scalarCutKernel(); }
#endif

}  // namespace spheretree::runtime

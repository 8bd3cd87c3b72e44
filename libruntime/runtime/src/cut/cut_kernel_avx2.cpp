// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx2 -mno-fma; called only on machines with AVX2.
#include "cut/cut_kernel_lanes.h"

namespace spheretree::runtime {

const CutKernel& avx2CutKernel() {
  static constexpr CutKernel kernel{cutBlock, nearWalls, signedDistances};
  return kernel;
}

}  // namespace spheretree::runtime

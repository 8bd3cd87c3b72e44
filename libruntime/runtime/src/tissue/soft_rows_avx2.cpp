// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx2 -mno-fma; called only on machines with AVX2.
#include "tissue/soft_rows_lanes.h"

namespace spheretree::runtime {

const SoftKernel& avx2SoftKernel() {
  static constexpr SoftKernel kernel{softRows, keepNear, findFront};
  return kernel;
}

}  // namespace spheretree::runtime

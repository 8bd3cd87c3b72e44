// SPDX-License-Identifier: Apache-2.0
#include "tissue/soft_rows_lanes.h"

namespace spheretree::runtime {

const SoftKernel& scalarSoftKernel() {
  static constexpr SoftKernel kernel{softRows, keepNear, findFront};
  return kernel;
}

#if !defined(__x86_64__)
const SoftKernel& avx2SoftKernel() { return scalarSoftKernel(); }
#endif

}  // namespace spheretree::runtime

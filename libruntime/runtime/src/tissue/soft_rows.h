// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kernel/kernel.h"

namespace spheretree::runtime {

/// For soft tissue. Both tables give the same bits.
struct SoftKernel {
  float (*rows)(const RowRequest&);  // of balls and patches; returns the smallest gap
  /// Stores the pairs whose ball is within `reach` of the flat triangle, in their order, and returns their number.
  /// `kept` may be `pairs` of the request.
  std::uint32_t (*keepNear)(const RowRequest&, float reach, std::uint32_t* kept);
  /// Sets in_front of the request for the balls of its pairs.
  void (*findFront)(const RowRequest&);
};

const SoftKernel& scalarSoftKernel();
const SoftKernel& avx2SoftKernel();  // only if avx2Kernel() is not null

}  // namespace spheretree::runtime

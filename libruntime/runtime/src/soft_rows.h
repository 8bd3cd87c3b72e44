// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kernel.h"

namespace spheretree::runtime {

/// Rows of balls and yielding patches; returns the smallest gap. Both functions give the same bits.
float softRowsScalar(const RowRequest& request);
float softRowsAvx2(const RowRequest& request);  // only if avx2Kernel() is not null

}  // namespace spheretree::runtime

// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "kernel.h"

namespace spheretree::runtime {

/// Rows of balls and patches that give way; returns the smallest gap. All give the same bits.
float softRowsScalar(const RowRequest& request);
float softRowsAvx2(const RowRequest& request);  // where avx2Kernel() is not null

}  // namespace spheretree::runtime

// SPDX-License-Identifier: Apache-2.0
// Compiled with -mavx2 -mno-fma; called only on machines with AVX2.
#include "soft_rows_lanes.h"

namespace spheretree::runtime {

float softRowsAvx2(const RowRequest& request) { return softRows(request); }

}  // namespace spheretree::runtime

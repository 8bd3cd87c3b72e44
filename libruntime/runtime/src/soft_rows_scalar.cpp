// SPDX-License-Identifier: Apache-2.0
#include "soft_rows_lanes.h"

namespace spheretree::runtime {

float softRowsScalar(const RowRequest& request) { return softRows(request); }

#if !defined(__x86_64__)
float softRowsAvx2(const RowRequest& request) { return softRows(request); }
#endif

}  // namespace spheretree::runtime

// SPDX-License-Identifier: Apache-2.0
// Formats sentences about faults. A call of a C function takes a tenth of the code size of concatenated strings, and
// the shared library of the runtime should stay small.
#pragma once

#include <string>

namespace spheretree {

/// std::snprintf to a string of at most 511 characters; the rest is cut off.
[[gnu::format(printf, 1, 2)]] std::string describe(const char* format, ...);

}  // namespace spheretree

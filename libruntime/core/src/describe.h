// SPDX-License-Identifier: Apache-2.0
// Sentences about faults. One call of a function of C takes a tenth of the code that joined strings take, and the
// shared library of the runtime is to stay small.
#pragma once

#include <string>

namespace spheretree {

/// std::snprintf to a string: at most 511 characters, the rest is cut off.
[[gnu::format(printf, 1, 2)]] std::string describe(const char* format, ...);

}  // namespace spheretree

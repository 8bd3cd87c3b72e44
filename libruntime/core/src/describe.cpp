// SPDX-License-Identifier: Apache-2.0
#include "describe.h"

#include <cstdarg>
#include <cstdio>

namespace spheretree {

std::string describe(const char* format, ...) {
  char text[512];
  std::va_list values;
  va_start(values, format);
  std::vsnprintf(text, sizeof text, format, values);
  va_end(values);
  return text;
}

}  // namespace spheretree

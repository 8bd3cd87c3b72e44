// SPDX-License-Identifier: Apache-2.0
#include "text/text_encoding.h"

#include "spheretree/formats/errors.h"

namespace spheretree::formats {

std::span<const char> asText(std::span<const char> bytes, const std::string& name) {
  const auto at = [&](std::size_t i) { return i < bytes.size() ? static_cast<unsigned char>(bytes[i]) : 0x20u; };
  if ((at(0) == 0xff && at(1) == 0xfe) || (at(0) == 0xfe && at(1) == 0xff) || at(0) == 0 || at(1) == 0)
    throw FormatError(name + ": is UTF-16 or UTF-32 text, or not text. Save it as UTF-8 or ASCII.");
  if (at(0) == 0xef && at(1) == 0xbb && at(2) == 0xbf) return bytes.subspan(3);
  return bytes;
}

}  // namespace spheretree::formats

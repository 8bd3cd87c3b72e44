// SPDX-License-Identifier: Apache-2.0
// The encoding of a text file.
#pragma once

#include <span>
#include <string>

namespace spheretree::formats {

/// Refuses UTF-16 and UTF-32, and removes a UTF-8 byte order mark.
/// @throws FormatError
std::span<const char> asText(std::span<const char> bytes, const std::string& name);

}  // namespace spheretree::formats

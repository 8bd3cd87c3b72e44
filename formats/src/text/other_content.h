// SPDX-License-Identifier: Apache-2.0
// Files that are no mesh of a format that is read here, although their names may say so: what they are, and what to do.
#pragma once

#include <optional>
#include <span>
#include <string>

namespace spheretree::formats {

struct OtherContent {
  std::string what;  // "a web page (HTML)"
  std::string next;  // a whole sentence: what makes a mesh of it
};

/// `name`: of the file, for commands. Empty for content that is not recognised.
std::optional<OtherContent> otherContentOf(std::span<const char> bytes, const std::string& name);

}  // namespace spheretree::formats

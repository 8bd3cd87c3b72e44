// SPDX-License-Identifier: Apache-2.0
// Search tree and skin within a tree in JSON. docs/file_format.md
#pragma once

#include <string>

#include "json_element.h"
#include "spheretree/core/skin.h"

namespace spheretree::formats {

/// Objects of JSON, several records a line, each line indented by two blanks.
std::string writeSearchJson(const SearchTree& search);
std::string writeSkinJson(const Skin& skin);

/// Whatever the elements hold, numbers are in the range of their types; the rest is the business of findFault().
/// @throws FormatError with the path of the element.
SearchTree readSearchJson(const JsonElement& element);
Skin readSkinJson(const JsonElement& element);

}  // namespace spheretree::formats

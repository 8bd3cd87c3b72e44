// SPDX-License-Identifier: Apache-2.0
// Search tree, skin and hulls within the JSON of a tree. docs/file_format.md
#pragma once

#include <string>

#include "spheretree/core/hulls.h"
#include "spheretree/core/skin.h"
#include "text/json_element.h"

namespace spheretree::formats {

/// JSON objects, several records a line, each line indented by two blanks.
std::string writeSearchJson(const SearchTree& search);
std::string writeSkinJson(const Skin& skin);
std::string writeHullsJson(const Hulls& hulls);

/// All numbers that are returned are in the range of their types; findFault() checks the rest.
/// @throws FormatError with the path of the element.
SearchTree readSearchJson(const JsonElement& element);
Skin readSkinJson(const JsonElement& element);
Hulls readHullsJson(const JsonElement& element);

}  // namespace spheretree::formats

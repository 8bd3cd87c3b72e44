// SPDX-License-Identifier: GPL-3.0-or-later
// JSON in the format that the programs write.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace spheretree::tool {

/// `indent`: blanks for each level; -1: everything on one line. Paths and names of parts need not be UTF-8, but JSON
/// must be: invalid sequences become U+FFFD.
inline std::string jsonText(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace spheretree::tool

// SPDX-License-Identifier: GPL-3.0-or-later
// JSON as the programs write it.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace spheretree::tool {

/// `indent` blanks a level; -1: all on one line. Paths and names of parts need not be UTF-8, but JSON is: what is none
/// becomes U+FFFD.
inline std::string jsonText(const nlohmann::ordered_json& json, int indent) {
  return json.dump(indent, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace spheretree::tool

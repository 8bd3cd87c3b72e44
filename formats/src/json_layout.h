// SPDX-License-Identifier: Apache-2.0
// JSON laid out for people who edit it: what fits on a line stands on a line.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace spheretree::formats {

/// The same value as json.dump(), with a line for each key of the top level and for each element of a long list; keys
/// below fill their lines up to 120 columns. Ends without a line break.
/// @throws nlohmann::json::exception for text that is not UTF-8.
std::string layOut(const nlohmann::ordered_json& json);

}  // namespace spheretree::formats

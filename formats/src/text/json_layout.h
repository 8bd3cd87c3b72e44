// SPDX-License-Identifier: Apache-2.0
// Formats JSON for people who edit it: values that fit on a line are written on one line.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace spheretree::formats {

/// The same value as json.dump(), with a line for each key of the top level and for each element of a long list; keys
/// below fill their lines up to 120 columns. There is no final line break.
/// @throws nlohmann::json::exception for text that is not UTF-8.
std::string layOut(const nlohmann::ordered_json& json);

}  // namespace spheretree::formats

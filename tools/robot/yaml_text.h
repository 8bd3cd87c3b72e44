// SPDX-License-Identifier: GPL-3.0-or-later
// YAML as every reader understands it: strings in quotes, numbers with a point, lists of numbers on one line.
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>

namespace spheretree::robot {

/// The shortest decimal that reads back as the same float, without an exponent (YAML 1.1 takes 1e-05 for a string):
/// "0.25", "-3.0".
std::string decimal(float value);
std::string decimal(double value);

/// A scalar that is a string whatever it looks like ("no", "1.0").
YAML::Node textNode(const std::string& text);
YAML::Node numberNode(double value);

/// Maps in the order in which their keys were set; ends in a new line. What was quoted when it was read stays a string.
std::string yamlText(const YAML::Node& node);

/// @throws formats::FileError, formats::FormatError with the line
YAML::Node readYaml(const std::filesystem::path& path);

}  // namespace spheretree::robot

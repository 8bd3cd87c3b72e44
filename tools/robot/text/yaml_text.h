// SPDX-License-Identifier: GPL-3.0-or-later
// YAML in a form that every reader understands: strings in quotes, numbers with a point, lists of numbers on one line.
#pragma once

#include <yaml-cpp/yaml.h>

#include <filesystem>
#include <string>

#include "spheretree/core/sphere.h"

namespace spheretree::robot {

/// The shortest decimal that reads back as the same float, without an exponent (YAML 1.1 reads 1e-05 as a string):
/// "0.25", "-3.0".
std::string decimal(float value);
std::string decimal(double value);
/// "X Y Z"
std::string centreText(const Sphere& sphere);

/// A scalar that is always a string, even if it looks different ("no", "1.0").
YAML::Node textNode(const std::string& text);
YAML::Node numberNode(double value);

/// Writes maps in the order in which their keys were set, with a final newline. Quoted scalars that were read stay
/// strings.
std::string yamlText(const YAML::Node& node);

/// @throws formats::FileError, formats::FormatError with the line
YAML::Node readYaml(const std::filesystem::path& path);

}  // namespace spheretree::robot

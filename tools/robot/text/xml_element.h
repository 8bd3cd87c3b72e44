// SPDX-License-Identifier: GPL-3.0-or-later
// Reads XML files of robots, with messages that name the file, the line and the element.
#pragma once

#include <tinyxml2.h>

#include <Eigen/Geometry>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace spheretree::robot {

using XmlElement = tinyxml2::XMLElement;

/// Reads the file into `document` and returns its root element. The file is recorded as an input of the run
/// (formats::readFile). `kind` is what the file should be, for messages: "a URDF".
/// @throws formats::FileError, formats::FormatError
const XmlElement& readXml(const std::filesystem::path& path, tinyxml2::XMLDocument& document, const std::string& kind);

/// The XML of a document, indented by two blanks.
std::string xmlText(const tinyxml2::XMLDocument& document);

/// Appends a new child.
XmlElement& addElement(tinyxml2::XMLNode& parent, const char* name);

void setText(XmlElement& element, const char* attribute, const std::string& value);

/// Where an element is, for messages and notes: "FILE:LINE: <axis> of joint elbow (link forearm)"; within a link
/// "FILE:LINE: <box> of link forearm"; for a link itself "FILE:LINE: link forearm". A joint is followed by its child.
std::string placeOf(const std::filesystem::path& path, const XmlElement& element);

/// @throws formats::FormatError: "PLACE: WHAT"
[[noreturn]] void refuse(const std::filesystem::path& path, const XmlElement& element, const std::string& what);

/// @throws formats::FormatError if it is missing or empty.
std::string requiredText(const std::filesystem::path& path, const XmlElement& element, const char* attribute);

/// A finite number; one that is too small for a double is 0. Empty if the attribute is missing or blank.
/// @throws formats::FormatError for anything else.
std::optional<double> optionalNumber(const std::filesystem::path& path, const XmlElement& element, const char* attribute);
/// @throws formats::FormatError if it is missing or blank, too.
double requiredNumber(const std::filesystem::path& path, const XmlElement& element, const char* attribute);

/// `count` finite numbers separated by blanks; empty if the attribute is missing or blank.
/// @throws formats::FormatError for anything else.
std::vector<double> numbers(const std::filesystem::path& path, const XmlElement& element, const char* attribute, std::size_t count);

/// <origin xyz="" rpy=""> of `parent`, [m] to [mm]; the identity if it has none. rpy: rotations about fixed x, y, z.
Eigen::Isometry3d originOf(const std::filesystem::path& path, const XmlElement& parent);

}  // namespace spheretree::robot

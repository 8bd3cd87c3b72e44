// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/text/xml_element.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <cstring>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::robot {
namespace {

/// The numbers of a text; empty if it contains anything else.
std::optional<std::vector<double>> numbersIn(const char* text) {
  std::vector<double> out;
  const char* end = text + std::char_traits<char>::length(text);
  for (const char* at = text;;) {
    while (at != end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r')) ++at;
    if (at == end) return out;
    if (*at == '+' && at + 1 != end && at[1] != '-') ++at;
    double value = 0;
    auto [next, error] = std::from_chars(at, end, value);
    if (error == std::errc::result_out_of_range) {  // too small or too large
      value = std::strtod(std::string(at, next).c_str(), nullptr);
      error = {};
    }
    const bool is_apart = next == end || *next == ' ' || *next == '\t' || *next == '\n' || *next == '\r';
    if (error != std::errc() || !std::isfinite(value) || !is_apart) return std::nullopt;
    out.push_back(value);
    at = next;
  }
}

const char* plainError(tinyxml2::XMLError error) {
  switch (error) {
    case tinyxml2::XML_ERROR_MISMATCHED_ELEMENT:
      return "an element is not closed, or under another name";
    case tinyxml2::XML_ERROR_PARSING_ATTRIBUTE:
      return "an attribute is not written as name=\"value\", or is given twice";
    case tinyxml2::XML_ERROR_PARSING_COMMENT:
      return "a comment has no end";
    case tinyxml2::XML_ELEMENT_DEPTH_EXCEEDED:
      return "elements are nested more than 500 deep";
    default:
      return "what stands there is no element, text or comment that ends";
  }
}

/// "link forearm" or "joint elbow (link forearm)"; empty for other elements.
std::string nameOf(const XmlElement& element) {
  const char* name = element.Attribute("name");
  const std::string kind = element.Name();
  if (!name || (kind != "link" && kind != "joint")) return "";
  const XmlElement* child = kind == "joint" ? element.FirstChildElement("child") : nullptr;
  const char* link = child ? child->Attribute("link") : nullptr;
  return kind + " " + name + (link ? std::string(" (link ") + link + ")" : "");
}

}  // namespace

const XmlElement& readXml(const std::filesystem::path& path, tinyxml2::XMLDocument& document, const std::string& kind) {
  constexpr std::uint64_t kMaxBytes = std::uint64_t{256} << 20;
  const std::vector<std::byte> bytes = formats::readFile(path, kMaxBytes);
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  const std::string_view all(text, bytes.size());
  const std::size_t first = all.find_first_not_of(all.starts_with("\xef\xbb\xbf") ? "\xef\xbb\xbf \t\r\n" : " \t\r\n");
  if (first == std::string_view::npos || all[first] != '<')
    throw formats::FormatError(formats::shownName(path) + ": is not " + kind +
                               ", which is XML: " + (first == std::string_view::npos ? "the file is empty." : "it does not begin with <."));
  const tinyxml2::XMLError error = document.Parse(text, bytes.size());
  const XmlElement* root = document.RootElement();
  if (error != tinyxml2::XML_SUCCESS || !root)
    throw formats::FormatError(formats::shownName(path) + ":" + std::to_string(std::max(1, document.ErrorLineNum())) +
                               ": is not well-formed XML: " +
                               (root || error != tinyxml2::XML_SUCCESS ? plainError(error) : "it has no element") + ". Export it again.");
  return *root;
}

std::string xmlText(const tinyxml2::XMLDocument& document) {
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

XmlElement& addElement(tinyxml2::XMLNode& parent, const char* name) {
  return *parent.InsertEndChild(parent.GetDocument()->NewElement(name))->ToElement();
}

void setText(XmlElement& element, const char* attribute, const std::string& value) { element.SetAttribute(attribute, value.c_str()); }

std::string placeOf(const std::filesystem::path& path, const XmlElement& element) {
  std::string place = formats::shownName(path) + ":" + std::to_string(element.GetLineNum()) + ": ";
  if (const std::string own = nameOf(element); !own.empty()) return place + own;
  place += std::string("<") + element.Name() + ">";
  for (const tinyxml2::XMLNode* at = &element; at; at = at->Parent())
    if (const XmlElement* e = at->ToElement())
      if (const std::string name = nameOf(*e); !name.empty()) return place + " of " + name;
  return place;
}

void refuse(const std::filesystem::path& path, const XmlElement& element, const std::string& what) {
  std::string message = placeOf(path, element) + ": " + what;
  std::replace(message.begin(), message.end(), '\n', ' ');  // of a value over several lines
  throw formats::FormatError(message);
}

std::string requiredText(const std::filesystem::path& path, const XmlElement& element, const char* attribute) {
  const char* value = element.Attribute(attribute);
  if (!value || !*value) refuse(path, element, std::string("needs the attribute ") + attribute + ".");
  return value;
}

std::vector<double> numbers(const std::filesystem::path& path, const XmlElement& element, const char* attribute, std::size_t count) {
  const char* text = element.Attribute(attribute);
  const auto values = numbersIn(text ? text : "");
  if (values && values->empty()) return {};
  if (!values || values->size() != count)
    refuse(path, element,
           std::string(attribute) + "=\"" + text + "\" should be " + std::to_string(count) + " finite number" + (count == 1 ? "." : "s.") +
               (std::strchr(text, '$') ? " It is xacro, which has to be expanded first." : ""));
  return *values;
}

std::optional<double> optionalNumber(const std::filesystem::path& path, const XmlElement& element, const char* attribute) {
  const std::vector<double> values = numbers(path, element, attribute, 1);
  return values.empty() ? std::nullopt : std::optional(values[0]);
}

double requiredNumber(const std::filesystem::path& path, const XmlElement& element, const char* attribute) {
  const std::optional<double> value = optionalNumber(path, element, attribute);
  if (!value) refuse(path, element, std::string("needs the attribute ") + attribute + ".");
  return *value;
}

Eigen::Isometry3d originOf(const std::filesystem::path& path, const XmlElement& parent) {
  Eigen::Isometry3d frame = Eigen::Isometry3d::Identity();
  const XmlElement* origin = parent.FirstChildElement("origin");
  if (!origin) return frame;
  if (const std::vector<double> xyz = numbers(path, *origin, "xyz", 3); !xyz.empty())
    frame.translation() = 1000 * Eigen::Vector3d(xyz[0], xyz[1], xyz[2]);
  if (const std::vector<double> rpy = numbers(path, *origin, "rpy", 3); !rpy.empty()) {
    using Eigen::AngleAxisd;
    using Eigen::Vector3d;
    frame.linear() = (AngleAxisd(rpy[2], Vector3d::UnitZ()) * AngleAxisd(rpy[1], Vector3d::UnitY()) * AngleAxisd(rpy[0], Vector3d::UnitX()))
                         .toRotationMatrix();
  }
  return frame;
}

}  // namespace spheretree::robot

// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/xml_element.h"

#include <charconv>
#include <cmath>

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
    if (*at == '+') ++at;
    double value = 0;
    const auto [next, error] = std::from_chars(at, end, value);
    const bool is_apart = next == end || *next == ' ' || *next == '\t' || *next == '\n' || *next == '\r';
    if (error != std::errc() || !std::isfinite(value) || !is_apart) return std::nullopt;
    out.push_back(value);
    at = next;
  }
}

}  // namespace

const XmlElement& readXml(const std::filesystem::path& path, tinyxml2::XMLDocument& document) {
  constexpr std::uint64_t kMaxBytes = std::uint64_t{256} << 20;
  const std::vector<std::byte> bytes = formats::readFile(path, kMaxBytes);
  const auto* text = reinterpret_cast<const char*>(bytes.data());
  if (document.Parse(text, bytes.size()) != tinyxml2::XML_SUCCESS)
    throw formats::FormatError(formats::shownName(path) + ":" + std::to_string(document.ErrorLineNum()) + ": is not well-formed XML (" +
                               document.ErrorName() + "). Export it again.");
  const XmlElement* root = document.RootElement();
  if (!root) throw formats::FormatError(formats::shownName(path) + ": holds no XML element.");
  return *root;
}

std::string xmlText(const tinyxml2::XMLDocument& document) {
  tinyxml2::XMLPrinter printer;
  document.Print(&printer);
  return printer.CStr();
}

void refuse(const std::filesystem::path& path, const XmlElement& element, const std::string& what) {
  throw formats::FormatError(formats::shownName(path) + ":" + std::to_string(element.GetLineNum()) + ": <" + element.Name() + ">: " + what);
}

std::string requiredText(const std::filesystem::path& path, const XmlElement& element, const char* attribute) {
  const char* value = element.Attribute(attribute);
  if (!value || !*value) refuse(path, element, std::string("needs the attribute ") + attribute + ".");
  return value;
}

std::vector<double> numbers(const std::filesystem::path& path, const XmlElement& element, const char* attribute, std::size_t count) {
  const char* text = element.Attribute(attribute);
  if (!text) return {};
  const auto values = numbersIn(text);
  if (!values || values->size() != count)
    refuse(path, element,
           std::string(attribute) + "=\"" + text + "\" should be " + std::to_string(count) + " finite number" + (count == 1 ? "." : "s."));
  return *values;
}

std::optional<double> optionalNumber(const std::filesystem::path& path, const XmlElement& element, const char* attribute) {
  const std::vector<double> values = numbers(path, element, attribute, 1);
  return values.empty() ? std::nullopt : std::optional(values[0]);
}

double requiredNumber(const std::filesystem::path& path, const XmlElement& element, const char* attribute) {
  (void)requiredText(path, element, attribute);
  return *optionalNumber(path, element, attribute);
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

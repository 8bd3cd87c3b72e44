// SPDX-License-Identifier: GPL-3.0-or-later
#include "robot/text/yaml_text.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <vector>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::robot {
namespace {

template <class Number>
std::string fixedDecimal(Number value) {
  std::array<char, 512> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value, std::chars_format::fixed).ptr;
  std::string out(text.data(), end);
  if (out.find('.') == std::string::npos) out += ".0";
  return out == "-0.0" ? "0.0" : out;
}

/// In double quotes, with escapes that JSON also has.
std::string quoted(const std::string& text) {
  constexpr const char* kHex = "0123456789abcdef";
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') out += '\\';
    if (byte >= 0x20)
      out += c;
    else
      out += std::string("\\u00") + kHex[byte >> 4] + kHex[byte & 15];
  }
  return out + '"';
}

/// A plain scalar is written unchanged; others are strings.
std::string scalarText(const YAML::Node& node) {
  if (node.IsNull()) return "null";
  return node.Tag() == "!" ? quoted(node.Scalar()) : node.Scalar();
}

/// Plain if no reader can take it for anything but a string.
std::string keyText(const std::string& key) {
  const bool is_word = key.size() > 3 && std::isalpha(static_cast<unsigned char>(key[0])) &&
                       std::all_of(key.begin(), key.end(), [](unsigned char c) { return std::isalnum(c) || c == '_'; });
  const bool is_special = key == "true" || key == "True" || key == "TRUE" || key == "false" || key == "False" || key == "FALSE" ||
                          key == "null" || key == "Null" || key == "NULL";
  return is_word && !is_special ? key : quoted(key);
}

bool isFlat(const YAML::Node& node) {
  for (const YAML::Node& item : node)
    if (!item.IsScalar() && !item.IsNull()) return false;
  return true;
}

void write(const YAML::Node& node, std::size_t indent, std::string& out);

void writeValue(const YAML::Node& value, std::size_t indent, std::string& out) {
  if (value.IsScalar() || value.IsNull() || !value.IsDefined()) {
    out += " " + (value.IsDefined() ? scalarText(value) : std::string("null")) + "\n";
  } else if (value.size() == 0) {
    out += value.IsMap() ? " {}\n" : " []\n";
  } else if (value.IsSequence() && isFlat(value)) {
    out += " [";
    for (std::size_t i = 0; i < value.size(); ++i) out += (i > 0 ? ", " : "") + scalarText(value[i]);
    out += "]\n";
  } else {
    out += "\n";
    write(value, indent, out);
  }
}

void write(const YAML::Node& node, std::size_t indent, std::string& out) {
  const std::string blanks(indent, ' ');
  if (node.IsMap()) {
    for (const auto& entry : node) {
      out += blanks + keyText(entry.first.Scalar()) + ":";
      writeValue(entry.second, indent + 2, out);
    }
    return;
  }
  for (const YAML::Node& item : node) {
    if (!item.IsMap() || item.size() == 0) {
      out += blanks + "-";
      writeValue(item, indent + 2, out);
      continue;
    }
    std::string inner;  // "- key: value", with the rest below the key
    write(item, indent + 2, inner);
    inner.replace(indent, 2, "- ");
    out += inner;
  }
}

}  // namespace

std::string decimal(float value) { return fixedDecimal(value); }
std::string decimal(double value) { return fixedDecimal(value); }
std::string centreText(const Sphere& s) { return decimal(s.x) + " " + decimal(s.y) + " " + decimal(s.z); }

YAML::Node textNode(const std::string& text) {
  YAML::Node node(text);
  node.SetTag("!");
  return node;
}

YAML::Node numberNode(double value) { return YAML::Node(decimal(value)); }

std::string yamlText(const YAML::Node& node) {
  std::string out;
  write(node, 0, out);
  return out;
}

YAML::Node readYaml(const std::filesystem::path& path) {
  constexpr std::uint64_t kMaxBytes = std::uint64_t{64} << 20;
  const std::vector<std::byte> bytes = formats::readFile(path, kMaxBytes);
  try {
    return YAML::Load(std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()));
  } catch (const YAML::Exception& error) {
    throw formats::FormatError(formats::shownName(path) + ":" + std::to_string(error.mark.line + 1) +
                               ": is not YAML or JSON: " + error.msg + ".");
  }
}

}  // namespace spheretree::robot

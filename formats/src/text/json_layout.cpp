// SPDX-License-Identifier: Apache-2.0
#include "text/json_layout.h"

namespace spheretree::formats {
namespace {

using OrderedJson = nlohmann::ordered_json;
constexpr std::size_t kLineLength = 120;

/// On one line, with blanks after commas and colons.
std::string onOneLine(const OrderedJson& json) {
  if (!json.is_structured()) return json.dump();
  std::string text(1, json.is_object() ? '{' : '[');
  for (const auto& [key, value] : json.items()) {
    if (text.size() > 1) text += ", ";
    if (json.is_object()) text += OrderedJson(key).dump() + ": ";
    text += onOneLine(value);
  }
  return text + (json.is_object() ? '}' : ']');
}

/// `column`: where the text begins; `fills`: keys of this object may share lines.
std::string laidOut(const OrderedJson& json, std::size_t column, bool fills) {
  std::string line = onOneLine(json);
  if (!json.is_structured() || json.empty() || (fills && column + line.size() <= kLineLength)) return line;
  const std::string margin = "\n" + std::string(column + 1, ' ');
  std::string text(1, json.is_object() ? '{' : '[');
  std::size_t at = column + 1;  // of the next character
  bool shares_line = true;      // whether further items may be added to the last line
  for (const auto& [key, value] : json.items()) {
    const std::string name = json.is_object() ? OrderedJson(key).dump() + ": " : "";
    std::string item = name + onOneLine(value);
    const bool is_first = text.size() == 1;
    if (!is_first) text += ",";
    const bool fits = shares_line && fills && json.is_object() && at + 2 + item.size() <= kLineLength;
    if (!is_first) text += fits ? " " : margin;
    if (!is_first) at = fits ? at + 2 : column + 1;
    shares_line = at + item.size() <= kLineLength;
    if (!shares_line) item = name + laidOut(value, at + name.size(), true);
    text += item;
    at += item.size();
  }
  return text + (json.is_object() ? '}' : ']');
}

}  // namespace

std::string layOut(const OrderedJson& json) { return laidOut(json, 0, false); }

}  // namespace spheretree::formats

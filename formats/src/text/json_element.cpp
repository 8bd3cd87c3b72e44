// SPDX-License-Identifier: Apache-2.0
#include "text/json_element.h"

#include <set>

#include "text/content_kind.h"

namespace spheretree::formats {
namespace {

/// For example "line 3, column 5", both counted from 1.
std::string placeAt(std::string_view text, std::size_t at) {
  const std::string_view before = text.substr(0, std::min(at, text.size()));
  const auto line = 1 + std::count(before.begin(), before.end(), '\n');
  const std::size_t begin = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  return "line " + std::to_string(line) + ", column " + std::to_string(before.size() - begin + 1);
}

/// Advice on common syntax that JSON does not have.
std::string adviceAt(std::string_view text, std::size_t at) {
  const std::string_view rest = text.substr(std::min(at, text.size()));
  if (rest.empty()) return "it ends too early; a bracket or a quotation mark is not closed";
  if (rest.starts_with("//") || rest.starts_with("/*") || rest.starts_with("#")) return "JSON has no comments; remove them";
  if (rest.starts_with("NaN") || rest.starts_with("nan") || rest.starts_with("Inf") || rest.starts_with("-Inf"))
    return "JSON has no NaN or infinity; give a number";
  if (rest.starts_with("'")) return "texts stand in double quotation marks";
  if (rest[0] == ']' || rest[0] == '}') return "a comma before a closing bracket, or a value is missing";
  return "something else is expected at " + inQuotes(rest.substr(0, std::min<std::size_t>(20, rest.find('\n'))));
}

}  // namespace

std::string jsonFault(std::string_view text, const nlohmann::json::exception& error) {
  const auto* parse_error = dynamic_cast<const nlohmann::json::parse_error*>(&error);
  if (!parse_error) {  // a number out of range: the parser gives it, but no place
    const std::string_view what = error.what();
    const std::size_t from = std::min(what.find('\''), what.size()), to = what.find('\'', std::min(from + 1, what.size()));
    const bool is_found = to != std::string_view::npos;
    return "is not JSON: the number " + (is_found ? inQuotes(what.substr(from + 1, to - from - 1)) : "") + " is too large.";
  }
  // The parser reports the last byte that it read, from 1: the end of the unexpected word.
  std::size_t at = parse_error->byte > 0 ? parse_error->byte - 1 : 0;
  const auto isWord = [&](std::size_t i) {
    const char c = text[i];
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '/';
  };
  const bool ends_word = at > 0 && at < text.size() && !isWord(at) && isWord(at - 1);  // "tru}" stops at the bracket
  if (ends_word) --at;
  while (at > 0 && at < text.size() && isWord(at) && isWord(at - 1)) --at;
  return placeAt(text, at) + ": is not JSON: " + adviceAt(text, at) + ".";
}

nlohmann::json parseJson(std::string_view text, const JsonSource& source) {
  // The keys of the open objects. Of two equal keys a parser silently drops one.
  std::vector<std::set<std::string>> open;
  const auto refuseTwins = [&](int, nlohmann::json::parse_event_t event, nlohmann::json& parsed) {
    if (event == nlohmann::json::parse_event_t::object_start) open.emplace_back();
    if (event == nlohmann::json::parse_event_t::object_end) open.pop_back();
    if (event == nlohmann::json::parse_event_t::key && !open.back().insert(parsed.get<std::string>()).second)
      throw FormatError(source.name + ": the key " + inQuotes(parsed.get<std::string>()) + " stands twice in one object. Leave one out.");
    return true;
  };
  try {
    return nlohmann::json::parse(text.begin(), text.end(), refuseTwins);
  } catch (const nlohmann::json::exception& error) {
    const std::string kind = describedContent(text);
    if (!kind.empty() && kind != "JSON") throw FormatError(source.name + ": is " + kind + ", not " + source.what + ".");
    throw FormatError(source.name + ": " + jsonFault(text, error));
  }
}

}  // namespace spheretree::formats

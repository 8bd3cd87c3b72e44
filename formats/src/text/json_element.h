// SPDX-License-Identifier: Apache-2.0
// A value of an untrusted JSON text, with its path in the text: every access is checked, and errors name the path.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "spheretree/formats/errors.h"
#include "spheretree/formats/nearest_word.h"
#include "text/text_scan.h"

namespace spheretree::formats {

/// The source of a text and its expected kind, such as "a scene (.scene.json)"; for messages.
struct JsonSource {
  std::string name, what;
};

/// @throws FormatError with the place of the first error, including duplicate keys in an object.
nlohmann::json parseJson(std::string_view text, const JsonSource& source);

/// The first error of a text that could not be parsed: "line 2, column 7: is not JSON: ...".
std::string jsonFault(std::string_view text, const nlohmann::json::exception& error);

/// Refers to the value and the source, which must outlive it.
class JsonElement {
 public:
  JsonElement(const nlohmann::json& value, std::string path, const JsonSource& source)
      : value_(value), path_(std::move(path)), source_(source) {}

  [[noreturn]] void fail(const std::string& what) const {
    throw FormatError(source_.name + ": " + (path_.empty() ? "the text" : path_) + " " + what + ".");
  }

  // Objects
  bool has(const char* key) const { return value_.is_object() && value_.contains(key); }
  JsonElement at(const char* key) const {
    if (!value_.is_object()) fail("is not an object");
    const auto found = value_.find(key);
    if (found == value_.end()) fail(std::string("has no \"") + key + "\"");
    return {*found, path_.empty() ? key : path_ + "." + key, source_};
  }
  /// The keys of an object, in the order of their bytes.
  std::vector<std::string> keys() const {
    if (!value_.is_object()) fail("is not an object");
    std::vector<std::string> out;
    for (const auto& item : value_.items()) out.push_back(item.key());
    return out;
  }
  /// Refuses unknown keys: they are most likely typing errors, and their values would be silently ignored.
  void onlyKeys(std::initializer_list<std::string_view> known) const {
    if (!value_.is_object()) fail("is not an object");
    for (const auto& item : value_.items()) {
      const std::string& key = item.key();
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      if (const auto nearest = nearestWord(std::string_view(key).substr(0, 40), known))
        fail("has the unknown key " + inQuotes(key) + "; the nearest known one is \"" + std::string(*nearest) + "\"");
      std::string all;
      for (const std::string_view k : known) all += (all.empty() ? "" : ", ") + std::string(k);
      fail("has the unknown key " + inQuotes(key) + "; known are " + all);
    }
  }

  // Arrays
  std::size_t size() const {
    if (!value_.is_array()) fail("is not an array");
    return value_.size();
  }
  JsonElement item(std::size_t index) const { return {value_[index], path_ + "[" + std::to_string(index) + "]", source_}; }

  // Values
  bool isNull() const { return value_.is_null(); }
  bool isText() const { return value_.is_string(); }
  bool truth() const {
    if (!value_.is_boolean()) fail("is neither true nor false");
    return value_.get<bool>();
  }
  double number() const {
    if (!value_.is_number()) fail("is not a number");
    const double value = value_.get<double>();
    if (!std::isfinite(value)) fail("is not finite");
    return value;
  }
  float smallNumber() const {
    const double value = number();
    if (std::abs(value) > std::numeric_limits<float>::max()) fail("is too large for a float");
    return static_cast<float>(value);
  }
  std::uint64_t whole(std::uint64_t max, std::uint64_t min = 0) const {
    const bool fits = value_.is_number_unsigned() && value_.get<std::uint64_t>() >= min && value_.get<std::uint64_t>() <= max;
    if (!fits) fail("is not a whole number from " + std::to_string(min) + " to " + std::to_string(max));
    return value_.get<std::uint64_t>();
  }
  std::int64_t integer(std::int64_t smallest, std::int64_t largest) const {
    const bool fits = value_.is_number_integer() && !(value_.is_number_unsigned() && value_.get<std::uint64_t>() > INT64_MAX) &&
                      value_.get<std::int64_t>() >= smallest && value_.get<std::int64_t>() <= largest;
    if (!fits) fail("is not a whole number from " + std::to_string(smallest) + " to " + std::to_string(largest));
    return value_.get<std::int64_t>();
  }
  std::string text() const {
    if (!value_.is_string()) fail("is not a text");
    return value_.get<std::string>();
  }

 private:
  const nlohmann::json& value_;
  std::string path_;
  const JsonSource& source_;
};

}  // namespace spheretree::formats

// SPDX-License-Identifier: GPL-3.0-or-later
// Reads JSON files that these programs wrote as typed values, with uniform messages for invalid files.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "spheretree/formats/errors.h"

namespace spheretree::pipeline {

/// @throws formats::FileError; formats::FormatError if the file is not JSON or not of this schema.
nlohmann::ordered_json readJson(const std::filesystem::path& path, const std::string& schema);

/// The result of `parse` for the JSON of a file. Its exceptions for a missing key or another type become a
/// formats::FormatError.
template <class Parse>
auto readJsonAs(const std::filesystem::path& path, const std::string& schema, Parse&& parse) {
  const nlohmann::ordered_json json = readJson(path, schema);
  try {
    return parse(json);
  } catch (const nlohmann::json::exception&) {
    throw formats::FormatError(path.string() + ": a field of the schema " + schema +
                               " is missing or of another type: another version wrote the file, or it was changed by hand. Make it again.");
  }
}

/// A null value is treated like a missing key: the result is empty.
template <class T>
std::optional<T> optionalAt(const nlohmann::ordered_json& json, const char* key) {
  const auto found = json.find(key);
  return found == json.end() || found->is_null() ? std::nullopt : std::optional<T>(found->template get<T>());
}

template <class T>
nlohmann::ordered_json orNull(const std::optional<T>& value) {
  return value ? nlohmann::ordered_json(*value) : nlohmann::ordered_json(nullptr);
}

}  // namespace spheretree::pipeline

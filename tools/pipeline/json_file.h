// SPDX-License-Identifier: GPL-3.0-or-later
// JSON files that these programs wrote, as typed values: one place says what is wrong with a file that is none.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>

#include "spheretree/formats/errors.h"

namespace spheretree::pipeline {

/// @throws formats::FileError; formats::FormatError if the file is not JSON or not of this schema.
nlohmann::ordered_json readJson(const std::filesystem::path& path, const std::string& schema);

/// What `parse` makes of the JSON. What it throws because a key is missing or of another type becomes a
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

/// Absent and null are the same: no value.
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

// SPDX-License-Identifier: GPL-3.0-or-later
// A comparison as JSON: compare.json (schema spheretree.comparison/1), and the files of finished runs.
#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

#include "pipeline/comparison/comparison_figures.h"

namespace spheretree::pipeline {

nlohmann::ordered_json toJson(const Comparison& comparison);
nlohmann::ordered_json toJson(const MeshFigures& mesh);
nlohmann::ordered_json toJson(const Run& run);
nlohmann::ordered_json toJson(const Sensitivity& sensitivity);

/// @throws nlohmann::json::exception if a key is missing or of another type; formats::FormatError for an unknown
/// builder or quality.
MeshFigures meshFiguresFromJson(const nlohmann::ordered_json& json);
Run runFromJson(const nlohmann::ordered_json& json);
Sensitivity sensitivityFromJson(const nlohmann::ordered_json& json);

/// Reads compare.json. @throws formats::FileError; formats::FormatError if it does not have this schema.
Comparison readComparison(const std::filesystem::path& path);

}  // namespace spheretree::pipeline

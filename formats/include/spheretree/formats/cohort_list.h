// SPDX-License-Identifier: Apache-2.0
// The list of a cohort: JSON lines, one for each patient: {"patient": "P001", "scene": "P001/mouth.scene.json"}.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace spheretree::formats {

struct CohortPatient {
  std::string name;  // also of the results folder: letters, digits, - and _, and after the first character dots; at most 100 characters
  std::filesystem::path scene;  // as written in the list: relative to the folder of the list
};

/// Skips empty lines. There must be at least one patient, and their names must differ in more than case.
/// @throws FileError; FormatError with the line and the reason.
std::vector<CohortPatient> readCohortList(const std::filesystem::path& path);
std::vector<CohortPatient> parseCohortList(std::string_view text, const std::string& name);

}  // namespace spheretree::formats

// SPDX-License-Identifier: Apache-2.0
// The list of a cohort: JSON lines, one for each patient: {"patient": "P001", "scene": "P001/mouth.scene.json"}.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace spheretree::formats {

struct CohortPatient {
  std::string name;             // of the folder of the results: letters, digits, - and _, then also dots; at most 100 characters
  std::filesystem::path scene;  // as it stands in the list: relative to the folder of the list
};

/// Empty lines are left out. At least one patient; names differ, in any case of letters.
/// @throws FileError; FormatError with the line and what is wrong with it.
std::vector<CohortPatient> readCohortList(const std::filesystem::path& path);
std::vector<CohortPatient> parseCohortList(std::string_view text, const std::string& name);

}  // namespace spheretree::formats

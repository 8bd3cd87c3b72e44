// SPDX-License-Identifier: Apache-2.0
// Labels of an intraoral scan in the format of the public set Teeth3DS+:
// {"id_patient": "...", "jaw": "upper" or "lower", "labels": [0, 0, 44, ...], "instances": [0, 0, 3, ...]}: a number
// for each vertex of the mesh file in its order (or for each face): 0 for gum, otherwise the FDI number of a tooth.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace spheretree::formats {

inline constexpr std::int32_t kMaxScanLabel = 999;

struct ScanLabels {
  std::string patient, jaw;          // jaw: "upper", "lower", or "" if the file does not specify it
  std::vector<std::int32_t> labels;  // 0 .. kMaxScanLabel, at least one
};

/// Numbers may be written as 44.0, jaws in any case and as maxilla and mandible. Other keys are ignored, since data
/// sets add their own.
/// @throws FileError; FormatError with the path of the element and the reason.
ScanLabels readScanLabels(const std::filesystem::path& path);
ScanLabels parseScanLabels(std::string_view text, const std::string& name);

}  // namespace spheretree::formats

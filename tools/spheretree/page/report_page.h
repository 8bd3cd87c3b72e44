// SPDX-License-Identifier: GPL-3.0-or-later
// The pages of `spheretree report`, and their figures.
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "page/page.h"
#include "spheretree/builder/progress.h"

namespace spheretree::tool {

struct Report {
  std::string html;
  Json figures;
};

/// The page of a folder that `spheretree batch` wrote; optionally with the recording of a run in its scene.
Report batchReport(const std::filesystem::path& folder, const std::optional<std::filesystem::path>& recording, std::size_t max_bytes,
                   builder::Progress& progress);

/// The page of a patient, in the patient's folder.
inline constexpr const char* kPatientPage = "report.html";

/// The page of a folder that `spheretree batch --cohort` wrote: its patients, the worst first. `page`: where it will
/// be, for links to the patients' pages that exist; empty: without links.
Report cohortReport(const std::filesystem::path& folder, const std::filesystem::path& page);

/// The page of a folder that `spheretree robot` wrote: the robot with its spheres, and the figures of its links.
Report robotReport(const std::filesystem::path& folder, std::size_t max_bytes, builder::Progress& progress);

/// The page of a recording; optionally with the compiled scene in which it was made.
Report recordingReport(const std::filesystem::path& recording, const std::optional<std::filesystem::path>& scene, std::size_t max_bytes,
                       builder::Progress& progress);

/// The page of a folder with the stability.json of haptic-player --scenario.
Report stabilityReport(const std::filesystem::path& folder, std::size_t max_bytes, builder::Progress& progress);

/// The 3D section: the view, and a time slider if there is a replay.
std::string viewSection(bool has_replay, const std::string& note);

/// The name of object `index` of the scene in 3D: a button to its worst spot, and one that hides it.
std::string objectButtons(const std::string& name, std::size_t index);

/// Boxes with large figures: name and value.
std::string figureBoxes(const std::vector<std::pair<std::string, std::string>>& boxes);

/// The result of a run, in sentences.
std::string runVerdict(const Json& figures);

/// The boxes of a run.
std::string recordingBoxes(const Json& figures);

}  // namespace spheretree::tool

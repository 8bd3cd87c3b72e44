// SPDX-License-Identifier: GPL-3.0-or-later
// The pages of `spheretree report`, and the figures that they show.
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

/// Of a folder that spheretree batch wrote; with the recording of a run in its scene, if there is one.
Report batchReport(const std::filesystem::path& folder, const std::optional<std::filesystem::path>& recording, std::size_t most_bytes,
                   builder::Progress& progress);

/// Of a folder that spheretree batch --cohort wrote: its patients, the worst first.
Report cohortReport(const std::filesystem::path& folder);

/// Of a recording, with the compiled scene that it was made in, if it is given.
Report recordingReport(const std::filesystem::path& recording, const std::optional<std::filesystem::path>& scene, std::size_t most_bytes,
                       builder::Progress& progress);

/// Of a folder with the stability.json of haptic-player --scenario.
Report stabilityReport(const std::filesystem::path& folder, std::size_t most_bytes, builder::Progress& progress);

/// The 3D section: view, and the row of the time slider if something can be replayed.
std::string viewSection(bool has_replay, const std::string& note);

/// Boxes of large figures: name and value.
std::string figureBoxes(const std::vector<std::pair<std::string, std::string>>& boxes);

/// What came of a run, in sentences.
std::string runVerdict(const Json& figures);

/// The boxes of a run.
std::string recordingBoxes(const Json& figures);

}  // namespace spheretree::tool

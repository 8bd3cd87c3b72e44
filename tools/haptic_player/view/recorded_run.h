// SPDX-License-Identifier: GPL-3.0-or-later
// Reads a recording, with every number bit for bit. Units: mm, N, N mm, s, us.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "model/stage.h"
#include "run/body_paths.h"
#include "run/recording.h"
#include "run/tissue_motion.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"
#include "streams/live_streams.h"

namespace spheretree::player {

struct RecordedRun {
  std::vector<RecordedStep> steps;  // at least one
  RunIdentity identity;             // empty members where the recording has no such information
};

/// Finds columns by their names in the first line, in any order. Unknown columns are ignored; penetration_mm, scene,
/// settings, hinges_deg, tissue_states, spin, removed_mm3 and layer are optional; RecordedStep::layer then counts the
/// names in the order in which they come.
/// @throws formats::FileError, formats::FormatError with line and column
RecordedRun readRun(const std::filesystem::path& path);

/// The scene file of a recording; empty for the built-in sample. @throws formats::FormatError if the recording does not
/// name it.
std::filesystem::path sceneOf(const RecordedRun& run, const std::filesystem::path& recording);

/// The mode in which a recording was made. @throws formats::FormatError for an unknown mode.
runtime::Mode modeOf(const RecordedRun& run, const std::filesystem::path& recording);

inline constexpr std::uint32_t kShownStates = 4;  // every 4th state, 25 a second, is sufficient for display

/// The data of a run that a view shows: each step, and the contacts of the scene at its pose.
struct ShownRun {
  std::vector<RecordedStep> steps;
  std::vector<std::uint32_t> contact_begin;  // (steps + 1) index into contacts
  std::vector<view::ShownContact> contacts;
  std::vector<TissueShapes> tissue;  // every kShownStates-th state, from the first on; empty if no solver moves tissue
  std::string note;                  // why there are no contacts; empty if there are

  view::LiveState at(std::size_t step) const;
  /// The shapes of soft tissue at this step; empty if there is none. Cost: a copy.
  TissueShapes tissueAt(std::size_t step) const;
};

/// Contacts are not recorded: the steps are computed again from the recorded poses, with identical results. If the
/// results differ, the scene has changed since, and `note` says so. `tissue`, of Clock::Replay and of this scene, takes
/// its states in the recorded steps; null: soft tissue moved by its compliance alone.
ShownRun shownRun(std::vector<RecordedStep> steps, const runtime::Scene& scene, runtime::Mode mode, const BodyPaths& bodies,
                  TissueMotion* tissue = nullptr);

}  // namespace spheretree::player

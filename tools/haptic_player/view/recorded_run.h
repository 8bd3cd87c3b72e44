// SPDX-License-Identifier: GPL-3.0-or-later
// A recording, read again: every number to the bit. Units: mm, N, N mm, s, us.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "body_paths.h"
#include "model/stage.h"
#include "recording.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"
#include "streams/live_streams.h"
#include "tissue_motion.h"

namespace spheretree::player {

struct RecordedRun {
  std::vector<RecordedStep> steps;  // at least one
  RunIdentity identity;             // empty where the recording does not say
};

/// Columns by their names in the first line, in any order; those that are unknown are ignored, and penetration_mm,
/// scene, settings and hinges_deg may lack.
/// @throws formats::FileError, formats::FormatError with line and column
RecordedRun readRun(const std::filesystem::path& path);

/// The scene file of a recording, or nothing for the built-in sample. @throws formats::FormatError if the recording
/// does not say.
std::filesystem::path sceneOf(const RecordedRun& run, const std::filesystem::path& recording);

/// The mode that a recording was made in. @throws formats::FormatError for one that is not known.
runtime::Mode modeOf(const RecordedRun& run, const std::filesystem::path& recording);

inline constexpr std::uint32_t kShownStates = 4;  // 25 a second are enough to be seen

/// What a view shows of a run: each step, and the contacts that the scene has at its pose.
struct ShownRun {
  std::vector<RecordedStep> steps;
  std::vector<std::uint32_t> contact_begin;  // (steps + 1) into contacts
  std::vector<view::ShownContact> contacts;
  std::vector<TissueShapes> tissue;  // every kShownStates-th state, from the first on; empty: none moves by a solver
  std::string note;                  // why there are no contacts; empty: there are

  view::LiveState at(std::size_t step) const;
  /// Of soft tissue at this step; empty without any. Cost: a copy.
  TissueShapes tissueAt(std::size_t step) const;
};

/// Contacts are not recorded: the steps are computed again from the recorded poses, which gives the same to the bit.
/// Where it does not, the scene has changed since, and `note` says so. `tissue`, of Clock::Replay and of this scene,
/// takes its states in the steps that took them; null: soft tissue moved by its compliance alone.
ShownRun shownRun(std::vector<RecordedStep> steps, const runtime::Scene& scene, runtime::Mode mode, const BodyPaths& bodies,
                  TissueMotion* tissue = nullptr);

}  // namespace spheretree::player

// SPDX-License-Identifier: GPL-3.0-or-later
// Recorded runs in a window or in pictures: one, or two side by side at the same time.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/stage.h"
#include "panel/viewer_state.h"
#include "replay/removal_replay.h"
#include "view/pictures.h"
#include "view/recorded_run.h"

namespace spheretree::player {

/// A run with its scene.
struct ReplayedRun {
  std::string title;
  std::unique_ptr<view::Stage> stage;
  ShownRun run;
  std::vector<std::string> layers;  // that RecordedStep::layer counts
  BodyPaths bodies;
  bool skin_contact = true;               // contact was computed with skins
  std::vector<view::FigureLine> results;  // figures of the whole run
  std::vector<std::string> notes;
};

/// Reads a run from a file. `scene`: a scene file that replaces the one named in the recording; may be empty.
/// @throws formats::FileError, formats::FormatError
ReplayedRun replayedRun(const std::filesystem::path& recording, const std::filesystem::path& scene, builder::Progress& progress);

/// Shows one or two runs, step by step.
class Replay {
 public:
  explicit Replay(std::vector<ReplayedRun> runs);
  view::ViewerState state;
  view::Playback playback;
  /// Shows the current step of the playback. A run that has ended shows its last step.
  void update();
  const view::Stage& stage() const { return *runs_[0].stage; }
  bool hasSkinContact() const { return runs_.back().skin_contact; }

 private:
  std::vector<ReplayedRun> runs_;
  std::vector<std::vector<view::PlotSample>> samples_;  // (runs)
  std::vector<std::vector<std::uint32_t>> faults_;      // (runs, steps) accumulated so far
  std::vector<view::RemovalReplay> removals_;           // (runs)
};

/// Runs until the window is closed or Ctrl-C.
void showReplay(Replay& replay, const LiveView::Options& options, builder::Progress& progress);
/// @throws tool::UsageError if no selected step is in the run
void drawReplay(Replay& replay, const PictureSettings& settings, builder::Progress& progress);

}  // namespace spheretree::player

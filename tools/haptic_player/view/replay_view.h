// SPDX-License-Identifier: GPL-3.0-or-later
// Recorded runs in a window or in pictures: one, or two side by side with one clock.
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "model/stage.h"
#include "panel/viewer_state.h"
#include "view/pictures.h"
#include "view/recorded_run.h"
#include "view/view_options.h"

namespace spheretree::player {

/// A run with what it ran in.
struct ReplayedRun {
  std::string title;
  std::unique_ptr<view::Stage> stage;
  ShownRun run;
  BodyPaths bodies;
  bool skin_contact = true;               // what contact was computed with
  std::vector<view::FigureLine> results;  // of the whole run
  std::vector<std::string> notes;
};

/// From a file. `scene`: empty, or the scene file to be used whatever the recording says.
/// @throws formats::FileError, formats::FormatError
ReplayedRun replayedRun(const std::filesystem::path& recording, const std::filesystem::path& scene, builder::Progress& progress);

/// One or two runs, step by step.
class Replay {
 public:
  explicit Replay(std::vector<ReplayedRun> runs);
  view::ViewerState state;
  view::Playback playback;
  /// Shows the step at which the playback stands. A run that is over stands at its end.
  void update();
  const view::Stage& stage() const { return *runs_[0].stage; }
  bool hasSkinContact() const { return runs_.back().skin_contact; }

 private:
  std::vector<ReplayedRun> runs_;
  std::vector<std::vector<view::PlotSample>> samples_;  // (runs)
  std::vector<std::vector<std::uint32_t>> faults_;      // (runs, steps) so far
};

/// What the options say of a look, a window and pictures.
view::Look lookOf(const ViewOptions& options);
LiveView::Options windowOf(const ViewOptions& options);
PictureSettings picturesOf(const ViewOptions& options);
/// Refuses what cannot be drawn or written. @throws tool::UsageError, formats::FileError
void checkPictures(const ViewOptions& options);

/// Until the window is closed or Ctrl-C.
void showReplay(Replay& replay, const LiveView::Options& options, builder::Progress& progress);
/// @throws tool::UsageError if no chosen step is in the run
void drawReplay(Replay& replay, const PictureSettings& settings, builder::Progress& progress);

}  // namespace spheretree::player

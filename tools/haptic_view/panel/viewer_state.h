// SPDX-License-Identifier: GPL-3.0-or-later
// All that a window shows and all that it answers: plain values between a program, its panels and its pictures.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "draw/camera.h"
#include "draw/look.h"
#include "hand/hand_input.h"
#include "panel/history.h"
#include "replay/playback.h"
#include "streams/live_streams.h"

namespace spheretree::view {

/// Something that can go wrong, and a sentence on what it means.
struct Lamp {
  std::string name, sentence;
  bool is_on = false, was_on = false;  // now; at some time of the run
  bool is_fault = true;                // else something that is meant to happen
};

/// A figure of the panel: "late steps", "0 of 5,012".
struct FigureLine {
  std::string name, value;
  bool is_bad = false;
};

/// One of up to six scenes side by side, or the only one.
struct Pane {
  const Stage* stage = nullptr;
  std::string title;
  bool has_state = false;
  LiveState state;
  std::vector<Configuration> carriers;               // where what moves is
  std::vector<std::vector<Eigen::Vector3f>> tissue;  // (object) displacements of the nodes of soft tissue [mm]
  std::span<const PlotSample> samples;               // in order; of a replay all of the run
  std::vector<FigureLine> figures;
  std::vector<Lamp> lamps;
  std::vector<std::string> notes;
};

/// A body that turns about a hinge and can be steered.
struct HingeControl {
  std::string name;
  double lowest = 0, highest = 0;  // [degree]
  double now = 0;
  std::optional<double> wish;  // empty: it goes as the scene says
};

struct ViewerState {
  // What is shown.
  std::string title;
  std::vector<Pane> panes;                    // one or two
  std::vector<std::optional<double>> limits;  // lines in the plots, in their order
  Look look;
  Camera camera;
  bool panels = true, help = false, follow = false, frozen = false;
  double plot_seconds = 10;
  std::string recording;  // file that is being written; empty: none
  bool can_record = false;
  std::string message;  // for a moment, at the lower edge
  // What is driven.
  HandInput* hand = nullptr;  // null: nobody holds the tool by this window
  std::vector<HingeControl> hinges;
  HandSource hand_source = HandSource::Mouse;
  Playback* playback = nullptr;  // null: no replay
  // What was asked for since the last frame.
  bool wants_record = false, wants_quit = false;

  bool hasPlots() const { return !panes.empty() && !panes[0].samples.empty(); }
};

/// Where things stand in a window [pixels].
struct Layout {
  Viewport scene, panel, scrubber, plots;  // without panels: the scene takes all
  std::vector<Viewport> panes;             // of the scene
};
Layout layoutOf(const ViewerState& state, int width, int height, double scale);

/// What a user asks of the first view; the rest is chosen.
struct CameraWish {
  std::optional<Eigen::Vector3d> from;  // direction from the target to the eye, not zero
  double within = 0;                    // radius of the ball about the tool that is to be seen [mm]; 0: chosen
};
/// firstCamera(), but for what is wished.
Camera wishedCamera(const Stage& stage, std::optional<Eigen::Vector3d> tool, const CameraWish& wish, const Viewport& viewport);

/// From where a stage is seen at first: the whole of it, or what is about the tool if that is much smaller. Of some
/// directions that in which the fewest balls hide the tool.
Camera firstCamera(const Stage& stage, std::optional<Eigen::Vector3d> tool, const Viewport& viewport);

}  // namespace spheretree::view

// SPDX-License-Identifier: GPL-3.0-or-later
// The complete state of a window: plain values shared by a program, its panels and its pictures.
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

/// A condition that can occur, and a sentence on what it means.
struct Lamp {
  std::string name, sentence;
  bool is_on = false, was_on = false;  // at this moment; at any time of the run
  bool is_fault = true;                // false: an intended condition
};

/// A figure of the panel, for example "late steps", "0 of 5,012".
struct FigureLine {
  std::string name, value;
  bool is_bad = false;
};

/// The only scene, or one of up to six side by side.
struct Pane {
  const Stage* stage = nullptr;
  std::string title;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero();  // of the camera, shiftBetween() the first stage and this one [mm]
  bool has_state = false;
  LiveState state;
  std::vector<Configuration> carriers;               // poses of the bodies
  std::vector<std::vector<Eigen::Vector3f>> tissue;  // (object) displacements of the nodes of soft tissue [mm]
  const Removal* removal = nullptr;                  // by the burr; null: there is none
  std::span<const PlotSample> samples;               // in order; in a replay all of the run
  std::vector<FigureLine> figures;
  std::vector<Lamp> lamps;
  std::vector<std::string> notes;
};

/// A value of the run that a slider can change: the angle of a hinge, or a setting of the rendering.
struct ValueControl {
  std::string name;
  const char* format = "%.1f deg";
  double lowest = 0, highest = 0, now = 0;
  std::optional<double> wish = {};  // empty: as the scene says
};

/// How a live run goes on. What a device does not do is told when it is asked for.
struct RunCourse {
  bool is_live = false, is_paused = false;
  int slowness = 1;            // a step in one of as many periods
  int wanted_steps = 0;        // in a pause, since the last frame
  bool wants_restart = false;  // since the last frame
  static constexpr int kSlowest = 32;
};

struct ViewerState {
  // What is shown.
  std::string title;
  std::vector<Pane> panes;                    // one or two
  std::vector<std::optional<double>> limits;  // lines in the plots, in their order
  Look look;
  Camera camera;
  bool fills_panes = false;  // each stage fills its pane; otherwise all have one scale
  bool panels = true, help = false, follow = false, frozen = false;
  RunCourse course;
  std::optional<Eigen::Vector3d> press_here;     // a place that the user may touch first [mm]
  std::optional<std::size_t> hovered, selected;  // objects of the first pane
  double plot_seconds = 10;
  std::string recording;  // file that is currently written; empty: none
  bool can_record = false, can_capture = false;
  std::string film;     // folder of the film that is being made; empty: none
  std::string message;  // shown for a moment at the lower edge
  // What the input controls.
  HandInput* hand = nullptr;  // null: this window does not control the tool
  std::vector<ValueControl> hinges, settings;
  std::vector<std::string> modes;  // of the rendering, to choose from: the one at the beginning, the other one; empty: no choice
  bool is_other_mode = false, wants_other_mode = false;
  HandSource hand_source = HandSource::Mouse;
  bool can_spin = false;         // the burr, whose spindle a request turns on or off
  Playback* playback = nullptr;  // null: no replay
  // Requests since the last frame.
  bool wants_record = false, wants_quit = false, wants_picture = false, wants_film = false, wants_spindle = false;

  bool hasPlots() const { return !panes.empty() && !panes[0].samples.empty(); }
};

/// What a drawer needs of a pane.
ShownState shownState(const Pane& pane);

/// Name and value of what is known about an object at this moment.
std::vector<FigureLine> objectFigures(const Pane& pane, std::size_t object);

/// The layout of a window [pixels].
struct Layout {
  Viewport scene, panel, scrubber, plots;  // without panels the scene has the whole window
  std::vector<Viewport> panes;             // of the scene
};
Layout layoutOf(const ViewerState& state, int width, int height, double scale);

/// The user's choices for the first view; everything else is automatic.
struct CameraWish {
  std::optional<Eigen::Vector3d> from;  // direction from the target to the eye, not zero
  double within = 0;                    // radius of the visible ball around the tool [mm]; 0: automatic
};
/// firstCamera() of the tool's pose, changed by the user's choices.
Camera wishedCamera(const Stage& stage, const std::optional<Configuration>& tool, const CameraWish& wish, const Viewport& viewport);

/// Points the camera at the first stage, from as far away as the whole of every pane needs.
void frameWhole(ViewerState& state, const Viewport& viewport);

/// The camera of a pane: that of the window, moved to the pane's stage, and nearer or farther by the ratio of the sizes
/// if each stage fills its pane.
Camera cameraOf(const ViewerState& state, std::size_t pane);

/// The shift [mm] of a pane beside another one: zero where their stages overlap, as different trees of one mesh do, so
/// that equal places are seen at equal places; otherwise from centre to centre.
Eigen::Vector3d shiftBetween(const Stage& first, const Stage& other);

/// The initial camera of a stage: it shows all teeth, in a scene that has teeth, or all objects; and the whole tool. If
/// the objects are much larger than the tool, it shows the surroundings of the tool. Of several directions, the one in
/// which the fewest balls hide tool and teeth is used.
Camera firstCamera(const Stage& stage, const std::optional<Configuration>& tool, const Viewport& viewport);

}  // namespace spheretree::view

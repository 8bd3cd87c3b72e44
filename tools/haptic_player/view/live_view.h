// SPDX-License-Identifier: GPL-3.0-or-later
// A run with a window: shows each step, passes the hand's target on, and records on request.
#pragma once

#include <chrono>
#include <memory>
#include <optional>

#include "hand/hand_filter.h"
#include "hand/rumble.h"
#include "hand/space_mouse.h"
#include "model/removal.h"
#include "panel/viewer.h"
#include "run/body_paths.h"
#include "run/play.h"
#include "run/recording.h"
#include "run/run_statistics.h"
#include "run/tissue_motion.h"
#include "streams/live_streams.h"
#include "window/capture.h"
#include "window/window.h"

namespace spheretree::player {

/// What a window and pictures need from a run.
class RunShown {
 public:
  view::LiveStreams streams;
  view::ViewerState state;
  view::RumbleSignal rumble;

  /// Sets the stage, its name, and notes on what cannot be shown.
  void setScene(const runtime::SceneDescription& scene, const std::filesystem::path& path);
  /// Takes the steps that the loop has published since the last call, and passes the hinge angles of the panels to the
  /// loop. `tissue`: of the run; null if no solver moves tissue.
  void update(TissueMotion* tissue);
  const view::Stage& stage() const { return stage_; }
  view::Pane& pane() { return state.panes[0]; }

 private:
  view::Stage stage_;
  BodyPaths bodies_;
  view::History history_;
  std::vector<view::PlotSample> frozen_;  // what plots show while they are frozen
  std::optional<view::Removal> removal_;  // by the burr; empty before setScene()
  std::vector<std::string> layers_;       // that RecordedStep::layer counts
  std::uint32_t faults_so_far_ = 0;
  view::StepTimes times_;
  std::size_t times_due_ = 0;
  std::uint32_t restarts_ = 0;
};

/// Settings that a window and a picture share.
struct ViewSettings {
  int width = 1280, height = 800;
  double scale = 0;  // of text and marks; 0: that of the display, for pictures 1
  view::Look look;
  view::CameraWish wish;
  bool panels = true, follow = false;
};

/// The path that names of recordings, pictures and films are made of: beside the recording of the run.
inline std::filesystem::path runName(const PlaySettings& settings) { return settings.record.empty() ? "run.csv" : settings.record; }

class LiveView final : public PlayObserver {
 public:
  struct Options : ViewSettings {
    view::HandSource hand = view::HandSource::Mouse;
  };
  /// Opens the window. `settings` must outlive it. @throws view::ViewError
  LiveView(const Options& options, const PlaySettings& settings);
  ~LiveView() override;

  void onScene(const runtime::SceneDescription& scene) override;
  view::LiveStreams* streams() override { return &shown_.streams; }
  device::IntendedPath handPath(device::IntendedPath path) override;
  bool onTurn(device::Device& device, ServoLoop& loop) override;
  /// `view`: frames; frame_us, from the start of a frame until it is passed to the display, without waiting for the
  /// next one; first_frame_s, since the trees were loaded; steps_not_shown.
  void addTo(nlohmann::ordered_json& summary) const override;

 private:
  void steer(double seconds);
  /// Starts and stops the burr on request: a key, a button of the panel, the gamepad or the 3D mouse.
  void turnSpindle();
  void showStatus(const device::DeviceStatus& status);
  void toggleRecording(ServoLoop& loop);
  void addSettings(const runtime::SceneDescription& scene);
  void openRumble();
  /// Passes pause, pace, steps and resets on to the device.
  void setCourse(device::Device& device, ServoLoop& loop);

  using Clock = std::chrono::steady_clock;
  Options options_;
  const PlaySettings& settings_;
  view::Window window_;
  RunShown shown_;
  std::unique_ptr<view::Viewer> viewer_;
  std::optional<view::SpaceMouse> space_mouse_;
  std::optional<view::Rumble> rumble_;
  view::Capture capture_;
  std::uint32_t pace_ = 1, asked_restarts_ = 0;  // of the device
  view::HandInput hand_;
  Configuration start_;                         // of the hand
  std::unique_ptr<RecordingWriter> recording_;  // started by the key
  bool first_recording_ = false;                // the recording of --record is still active
  Clock::time_point rated_;
  std::uint64_t rated_ticks_ = 0;
  double rate_ = 0;
  TimeHistogram frames_;
  Clock::time_point loaded_;
  double first_frame_ = 0;  // [s]
  bool has_camera_ = false, stop_asked_ = false, pad_button_ = false;
};

/// The path of a hand that follows an input: the newest target of `streams`, smoothed by a HandFilter; `start` until
/// there is one.
device::IntendedPath drivenPath(view::LiveStreams& streams, const Configuration& start);

}  // namespace spheretree::player

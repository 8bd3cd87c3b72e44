// SPDX-License-Identifier: GPL-3.0-or-later
// One servo step of the player: a pose in, a wrench out, and one row for the recording and the statistics.
#pragma once

#include <array>
#include <atomic>
#include <optional>
#include <span>
#include <vector>

#include "run/body_paths.h"
#include "run/recording.h"
#include "run/run_statistics.h"
#include "run/scene_tuner.h"
#include "run/tissue_motion.h"
#include "spheretree/device/device.h"
#include "spheretree/device/tool_mount.h"
#include "spheretree/runtime/step.h"
#include "streams/live_streams.h"

namespace spheretree::player {

class ServoLoop final : public device::Renderer {
 public:
  struct Options {
    runtime::Mode mode = runtime::Mode::Constrained;
    bool wait = false;                       // wait if the ring buffer of the recording is full, instead of losing rows
    TissueMotion* tissue = nullptr;          // large deformation of soft tissue; must outlive the loop
    bool cuts = false;                       // the scene has a burr and something to cut
    std::vector<bool> spins;                 // (ms) whether the spindle turns; after the end, as at the end; empty: it always turns
    std::uint32_t spindle_buttons = 0;       // if not 0, it turns while one of these buttons of the device is held
    const BodyPaths* bodies = nullptr;       // poses of bodies at each tick; must outlive the loop
    std::optional<device::ToolMount> mount;  // absent: the device reports the pose of the tool in the world
    runtime::Scene* tuned = nullptr;         // the scene of the loop, if its `live` streams may change its settings
    bool real_time_thread = false;           // the first step requests a real-time priority for its thread
  };
  /// `scene`, `recording` and `live` must outlive the loop; the latter two may be null.
  ServoLoop(const runtime::Scene& scene, RecordingWriter* recording, const Options& options, view::LiveStreams* live = nullptr);

  /// Computes the step of tick n (0, 1, ...) at n times the scene's step time. No allocation, lock or I/O (except
  /// `wait`). After a restart of the device n begins at 0 again, with bodies and tissue as at the start.
  device::Rendered render(const device::DeviceState& state) noexcept override;

  /// Sets the writer for the rows of later steps; null: none. Call it from one thread, which must not be that of the
  /// steps. Returns true when the current step has ended, so that the former writer may be finished; false if it has
  /// not ended within a second.
  bool record(RecordingWriter* recording) noexcept;

  // After the last step.
  const RunStatistics& statistics() const { return statistics_; }
  TissueMotion* tissue() const { return options_.tissue; }
  std::uint32_t tissueStates() const { return tissue_states_; }  // number of states used
  // From any thread.
  double force() const { return force_.load(std::memory_order_relaxed); }  // of the last step [N]
  double time() const { return time_.load(std::memory_order_relaxed); }    // that it took [us]
  runtime::Mode mode() const { return mode_.load(std::memory_order_relaxed); }
  int priorityError() const {
    return priority_error_.load(std::memory_order_relaxed);
  }  // errno of the request; 0: granted, -1: not requested

 private:
  void restart() noexcept;
  /// Takes the mode that the view asks for, once that cannot be felt.
  void changeMode() noexcept;
  void publish(const RecordedStep& row) noexcept;
  void turnSpindle(double time, std::uint32_t buttons) noexcept;
  void addCut(RecordedStep& row) const noexcept;
  /// Moves the hinges towards the angles set in the view, at the speed of a jaw; otherwise along the path of the scene.
  void steerHinges(const HingeAngles& path) noexcept;

  const runtime::Scene& scene_;
  std::atomic<RecordingWriter*> recording_;
  Options options_;
  view::LiveStreams* live_;
  std::optional<SceneTuner> tuner_;  // made before the workspace
  runtime::Workspace workspace_;
  RunStatistics statistics_;
  std::uint64_t ticks_ = 0;
  std::uint32_t restarts_ = 0;
  double torque_ = 0;  // of the last step [N mm]
  std::uint32_t tissue_states_ = 0;
  HingeAngles hinges_{};
  std::array<bool, kMaxHinges> is_steered_{};
  std::atomic<std::uint64_t> begun_{0}, ended_{0};  // steps
  std::atomic<double> force_{0}, time_{0};
  std::atomic<int> priority_error_{-1};
  std::atomic<runtime::Mode> mode_;
};

/// The contact in the form that a view shows.
view::ShownContact shownContact(const runtime::Contact& contact) noexcept;

/// The row of a step; its contact columns are computed from `contacts`.
RecordedStep recordedStep(std::uint64_t tick, const Configuration& haptic, const runtime::StepResult& result,
                          const runtime::StageTimes& times, double total_us, std::span<const runtime::Contact> contacts) noexcept;

}  // namespace spheretree::player

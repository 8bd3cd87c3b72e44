// SPDX-License-Identifier: GPL-3.0-or-later
// The record of a run: one row of CSV for each servo step, on its way from the servo thread to a file.
// Columns: docs/haptic_player.md. Units: mm, N, N mm, s; times of stages in us.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "spheretree/formats/file_io.h"
#include "streams/recorded_step.h"
#include "streams/step_ring.h"

namespace spheretree::player {

/// What a recording belongs to. It stands in the first row, so that a replay finds its scene.
struct RunIdentity {
  std::string scene;                      // path of the scene file from the folder of the recording, or kSampleScene; empty: not said
  std::string settings;                   // what else the steps depend on, as "mode=constrained contact=skin"
  std::vector<std::string> objects = {};  // names, for the column touched
  std::size_t hinges = 0;                 // how many angles the column hinges_deg has
  bool has_tissue = false;                // there is a column tissue_states
  bool has_passivity = false;             // and those of passivity control
};
inline constexpr const char* kSampleScene = "sample";  // the built-in one

/// The header line of the numbers, with its end of line. RecordingWriter adds the columns scene, settings, touched,
/// friction_n, slip_mm_s and hinges_deg, tissue_states where tissue moves by a solver, and passivity_n,
/// passivity_nmm and passivity_mj with passivity control.
std::string_view recordingHeader();

/// Appends one line. Numbers are the shortest decimals that read back as the same double: same run, same bytes.
void appendRow(std::string& text, const RecordedStep& row);

/// Rows from one thread to a file that appears under its name only at finish(). push() takes no lock and allocates
/// nothing: rows go through a ring to a thread of their own, which formats and writes.
class RecordingWriter {
 public:
  /// `capacity`: rows that may wait, a power of two. @throws formats::FileError
  explicit RecordingWriter(const std::filesystem::path& path, RunIdentity identity = {}, std::size_t capacity = 1 << 15);
  ~RecordingWriter();  // without finish(): nothing is left behind
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// From one thread only. False, and the row is lost and counted, if the ring is full.
  bool push(const RecordedStep& row) noexcept { return ring_.push(row); }
  /// As push(), but waits for room: for runs that do not keep real time.
  void pushWaiting(const RecordedStep& row) noexcept;

  /// Writes what is left and puts the file under its name. Once. @throws formats::FileError
  void finish();
  /// Rows that did not fit into the ring, so far. From any thread.
  std::uint64_t lost() const { return ring_.lost(); }
  const std::filesystem::path& path() const { return path_; }

 private:
  void appendFullRow(std::string& text, const RecordedStep& row);
  void drain();
  void stop() noexcept;

  view::StepRing<RecordedStep> ring_;
  std::filesystem::path path_;
  RunIdentity identity_;
  bool identity_written_ = false;
  std::atomic<bool> stop_{false}, failed_{false};
  std::exception_ptr error_;
  formats::WholeFile file_;
  std::thread thread_;
};

}  // namespace spheretree::player

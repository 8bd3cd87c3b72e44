// SPDX-License-Identifier: GPL-3.0-or-later
// The recording of a run: one CSV row for each servo step, transferred from the servo thread to a file. Columns:
// docs/haptic_player.md. Units: mm, N, N mm, s; times of stages in us.
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

/// What a recording belongs to. It is stored in the first row, so that a replay finds its scene.
struct RunIdentity {
  std::string scene;                      // path of the scene file relative to the folder of the recording, or kSampleScene; empty: unknown
  std::string settings;                   // further settings on which the steps depend, such as "mode=constrained contact=skin"
  std::vector<std::string> objects = {};  // their names, for the column `touched`
  std::size_t hinges = 0;                 // number of angles in the column hinges_deg
  bool has_tissue = false;                // whether there is a column tissue_states
  bool has_passivity = false;             // whether there are the columns of passivity control
  std::vector<std::string> layers = {};  // of all objects that can be cut, in the order of the scene; none: there are no columns of cutting
};
inline constexpr const char* kSampleScene = "sample";  // the built-in scene

/// The header line of the numeric columns, with its end of line. RecordingWriter adds the columns scene, settings,
/// touched, friction_n, slip_mm_s and hinges_deg; tissue_states if a solver moves tissue; passivity_n,
/// passivity_nmm and passivity_mj with passivity control; and spin, removed_mm3 and layer if a burr can cut.
std::string_view recordingHeader();

/// Appends one line. Numbers are the shortest decimals that read back as the same double: same run, same bytes.
void appendRow(std::string& text, const RecordedStep& row);

/// Writes rows from one thread to a file that gets its name only at finish(). push() takes no lock and allocates
/// nothing: rows go through a ring buffer to a separate thread, which formats and writes them.
class RecordingWriter {
 public:
  /// `capacity`: rows in the ring buffer, a power of two. @throws formats::FileError
  explicit RecordingWriter(const std::filesystem::path& path, RunIdentity identity = {}, std::size_t capacity = 1 << 15);
  ~RecordingWriter();  // without finish(), no file is left behind
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// May be called from one thread only. Returns false, and counts the row as lost, if the ring buffer is full.
  bool push(const RecordedStep& row) noexcept { return ring_.push(row); }
  /// As push(), but waits for space: for runs that do not keep real time.
  void pushWaiting(const RecordedStep& row) noexcept;

  /// Writes the remaining rows and gives the file its name. Call it once. @throws formats::FileError
  void finish();
  /// Number of rows lost so far because the ring buffer was full. May be called from any thread.
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

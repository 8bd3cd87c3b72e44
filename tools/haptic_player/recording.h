// SPDX-License-Identifier: GPL-3.0-or-later
// The record of a run: one row of CSV for each servo step, on its way from the servo thread to a file.
// Columns: contract of the program, docs/haptic_player.md. Units: mm, N, N mm, s; times of stages in us.
#pragma once

#include <atomic>
#include <cstdint>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "spheretree/core/rigid.h"
#include "spheretree/formats/file_io.h"

namespace spheretree::player {

struct RecordedStep {
  std::uint64_t tick = 0;
  double time = 0;        // of the tick [s]
  Configuration haptic;   // of the reference point, world
  Configuration graphic;  // "
  Wrench wrench;          // on the hand about the reference point, before the device's own limits
  std::uint32_t pairs = 0, rows = 0, active = 0, qp_iterations = 0, faults = 0;
  double find_us = 0, rows_us = 0, qp_us = 0, total_us = 0;
};

/// The header line, with its end of line.
std::string_view recordingHeader();

/// Appends one line. Numbers are the shortest decimals that read back as the same double: same run, same bytes.
void appendRow(std::string& text, const RecordedStep& row);

/// Rows from one thread to a file that appears under its name only at finish(). push() takes no lock and allocates nothing: rows go
/// through a ring to a thread of their own, which formats and writes.
class RecordingWriter {
 public:
  /// `capacity`: rows that may wait, a power of two. @throws formats::FileError
  explicit RecordingWriter(const std::filesystem::path& path, std::size_t capacity = 1 << 15);
  ~RecordingWriter();  // without finish(): nothing is left behind
  RecordingWriter(const RecordingWriter&) = delete;
  RecordingWriter& operator=(const RecordingWriter&) = delete;

  /// From one thread only. False, and the row is lost and counted, if the ring is full.
  bool push(const RecordedStep& row) noexcept;
  /// As push(), but waits for room: for runs that do not keep real time.
  void pushWaiting(const RecordedStep& row) noexcept;

  /// Writes what is left and puts the file under its name. Once. @throws formats::FileError
  void finish();
  std::uint64_t lost() const { return lost_; }

 private:
  void drain();
  void stop() noexcept;

  std::vector<RecordedStep> ring_;
  std::atomic<std::uint64_t> written_{0}, read_{0};  // rows since the start
  std::atomic<bool> stop_{false}, failed_{false};
  std::uint64_t lost_ = 0;
  std::exception_ptr error_;
  formats::WholeFile file_;
  std::thread thread_;
};

}  // namespace spheretree::player

// SPDX-License-Identifier: GPL-3.0-or-later
// Shows the progress of a verb on stderr.
#pragma once

#include <chrono>
#include <string>

#include "spheretree/builder/progress.h"

namespace spheretree::tool {

class ProgressBar : public builder::Progress {
 public:
  /// `kind`: auto (a bar on a terminal, plain on one that cannot draw over its line, else none), bar, plain (a line for
  /// each stage, and one every ten seconds within it), json (an object a line) or none. Short work shows nothing: bar
  /// and plain wait for half a second.
  ProgressBar(const std::string& kind, bool quiet);
  ~ProgressBar() override;  // clears it
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void stage(std::string_view name) override;
  void advance(double fraction) override;

 private:
  using Clock = std::chrono::steady_clock;
  enum class Kind { Bar, Plain, Json, None };
  void draw(double fraction, bool new_stage);
  double seconds() const;
  std::string timeLeft(double fraction, Clock::time_point now) const;
  std::string barText(double fraction, Clock::time_point now, int columns) const;
  void drawPlain(double fraction, Clock::time_point now);

  Kind kind_;
  std::string stage_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_drawn_ = start_, stage_start_ = start_, last_plain_ = start_;
  bool stage_shown_ = false;
};

}  // namespace spheretree::tool

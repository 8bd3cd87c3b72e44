// SPDX-License-Identifier: GPL-3.0-or-later
// Shows the progress of a verb on stderr.
#pragma once

#include <chrono>
#include <optional>
#include <string>

#include "work_progress.h"

namespace spheretree::tool {

class ProgressBar : public WorkProgress {
 public:
  /// `kind`: auto (a bar on a terminal; plain on a terminal that cannot overwrite its line; otherwise none), bar, plain
  /// (a line for each stage, and one every ten seconds within it), json (an object a line) or none. Short work shows
  /// nothing: bar and plain start after half a second. For work on many objects, bar and plain also print a line for
  /// each finished object.
  ProgressBar(const std::string& kind, bool quiet);
  ~ProgressBar() override;  // clears it
  ProgressBar(const ProgressBar&) = delete;
  ProgressBar& operator=(const ProgressBar&) = delete;

  void stage(std::string_view name) override;
  void advance(double fraction) override;
  void share(double begin, double end) override;
  void advance(double fraction, const Objects& objects) override;
  void finished(const Finished& object) override;

 private:
  using Clock = std::chrono::steady_clock;
  enum class Kind { Bar, Plain, Json, None };
  void draw(double fraction, bool new_stage);
  double seconds() const;
  std::string timeLeft(double fraction, Clock::time_point now) const;
  std::string barText(double fraction, Clock::time_point now, int columns) const;
  std::string objectsText() const;
  std::optional<double> secondsLeft(double fraction, Clock::time_point now) const;
  double whole(double fraction) const { return share_ ? share_->begin + fraction * (share_->end - share_->begin) : fraction; }
  void drawPlain(double fraction, Clock::time_point now);

  Kind kind_;
  std::string stage_;
  Clock::time_point start_ = Clock::now();
  Clock::time_point last_drawn_ = start_, stage_start_ = start_, last_plain_ = start_;
  bool stage_shown_ = false, header_shown_ = false;
  struct Share {
    double begin, end;
  };
  std::optional<Share> share_;
  std::optional<Objects> objects_;  // of the stage
};

}  // namespace spheretree::tool

// SPDX-License-Identifier: GPL-3.0-or-later
// Where a replay stands: plays, waits, goes slowly, jumps, begins again. Steps are of 1 ms.
#pragma once

#include <cstddef>

namespace spheretree::view {

class Playback {
 public:
  /// `steps` > 0: of the longest run.
  explicit Playback(std::size_t steps) : steps_(steps) {}

  std::size_t step() const { return static_cast<std::size_t>(at_); }
  std::size_t steps() const { return steps_; }
  bool isPlaying() const { return playing_; }
  double speed() const { return speed_; }
  bool loops = false;

  void play();  // from the start if it stands at the end
  void pause() { playing_ = false; }
  void toggle() { playing_ ? pause() : play(); }
  /// To a step, or the nearest that there is.
  void seek(double step);
  /// By so many steps; it then waits there.
  void nudge(double steps);
  /// In [1/1000, 8]: 1 is as it was.
  void setSpeed(double speed);
  /// So much later by the clock on the wall [s].
  void advance(double seconds);

 private:
  std::size_t steps_;
  double at_ = 0, speed_ = 1;
  bool playing_ = false;
};

}  // namespace spheretree::view

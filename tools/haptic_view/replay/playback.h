// SPDX-License-Identifier: GPL-3.0-or-later
// The position of a replay: plays, pauses, changes speed, jumps, begins again. Steps are of 1 ms.
#pragma once

#include <cstddef>

namespace spheretree::view {

class Playback {
 public:
  /// `steps` > 0: number of steps of the longest run.
  explicit Playback(std::size_t steps) : steps_(steps) {}

  std::size_t step() const { return static_cast<std::size_t>(at_); }
  std::size_t steps() const { return steps_; }
  bool isPlaying() const { return playing_; }
  double speed() const { return speed_; }
  bool loops = false;

  void play();  // from the start if it is at the end
  void pause() { playing_ = false; }
  void toggle() { playing_ ? pause() : play(); }
  /// Jumps to a step, or to the nearest existing one.
  void seek(double step);
  /// Moves by this number of steps and pauses.
  void nudge(double steps);
  /// `speed` in [1/1000, 8]; 1 is real time.
  void setSpeed(double speed);
  /// Advances by an elapsed real time [s].
  void advance(double seconds);

 private:
  std::size_t steps_;
  double at_ = 0, speed_ = 1;
  bool playing_ = false;
};

}  // namespace spheretree::view

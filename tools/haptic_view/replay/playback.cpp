// SPDX-License-Identifier: GPL-3.0-or-later
#include "replay/playback.h"

#include <algorithm>
#include <cmath>

namespace spheretree::view {

void Playback::play() {
  if (step() + 1 >= steps_) at_ = 0;
  playing_ = true;
}

void Playback::seek(double step) { at_ = std::clamp(step, 0.0, static_cast<double>(steps_ - 1)); }

void Playback::nudge(double steps) {
  pause();
  seek(std::floor(at_) + steps);
}

void Playback::setSpeed(double speed) { speed_ = std::clamp(speed, 0.001, 8.0); }

void Playback::advance(double seconds) {
  if (!playing_ || !(seconds > 0)) return;
  const double last = static_cast<double>(steps_ - 1), next = at_ + 1000 * speed_ * seconds;
  if (next < last) {
    at_ = next;
  } else if (loops) {
    at_ = last > 0 ? std::fmod(next, last) : 0;
  } else {
    at_ = last;
    playing_ = false;
  }
}

}  // namespace spheretree::view

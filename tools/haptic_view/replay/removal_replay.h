// SPDX-License-Identifier: GPL-3.0-or-later
// What a burr had removed at each step of a recorded run.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "model/removal.h"

namespace spheretree::view {

class RemovalReplay {
 public:
  using Carriers = std::function<std::vector<Configuration>(const player::RecordedStep&)>;
  /// `stage` and `steps` must outlive the object. `carriers`: the poses of the bodies at a step.
  RemovalReplay(const Stage& stage, std::span<const player::RecordedStep> steps, Carriers carriers);

  /// After `step`. Takes the steps since the last call, or since the nearest of some states that are kept, at most a
  /// twelfth of the run. Null without a burr or without anything to cut.
  const Removal* at(std::size_t step);

 private:
  struct Kept {
    std::size_t next;  // the first step that it does not hold
    Removal removal;
  };
  std::span<const player::RecordedStep> steps_;
  Carriers carriers_;
  std::vector<Kept> kept_;
  Kept now_;
  std::size_t every_ = 1000;  // steps between those that are kept
};

}  // namespace spheretree::view

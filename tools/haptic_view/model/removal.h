// SPDX-License-Identifier: GPL-3.0-or-later
// What the burr of a stage removes of its objects in a run, step by step. Units: mm.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "model/cut_surface.h"
#include "model/stage.h"
#include "streams/recorded_step.h"

namespace spheretree::view {

/// Copies share what they have in common, so that one can be kept for each of some times.
class Removal {
 public:
  /// `stage` must outlive the object, which is empty if the stage has no burr or nothing to cut.
  explicit Removal(const Stage& stage);
  bool empty() const { return objects_.empty(); }

  /// The next step of the run: a burr that spins removes what it sweeps from its place in the step before. `carriers`:
  /// as in poseOf(), at this step. The surfaces depend on the steps alone. They are behind by less than an eighth of a
  /// spacing, so that the cost depends on the way and not on the time.
  void add(const player::RecordedStep& step, std::span<const Configuration> carriers);

  /// Of an object of the stage; null if it cannot be cut.
  const CutSurface* of(std::size_t object) const;

 private:
  struct Object {
    std::size_t index;
    CutSurface surface;
    std::vector<Eigen::Vector3d> before, removed_to;  // (ball) at the last step; where its way has been removed to
  };
  const Stage* stage_;
  std::vector<Object> objects_;
  bool has_before_ = false, was_spinning_ = false;
};

}  // namespace spheretree::view

// SPDX-License-Identifier: GPL-3.0-or-later
// Changes the coupling and the friction of a scene while it is played, so slowly that the force does not jump.
// Units: mm, N, s.
#pragma once

#include <limits>
#include <vector>

#include "scene/compiled_scene.h"
#include "streams/live_streams.h"

namespace spheretree::player {

class SceneTuner {
 public:
  /// Each step covers this share of the way to the requested value, so that half of it takes 35 ms. The force, which is
  /// proportional to the stiffness, changes by no larger share.
  static constexpr double kShare = 0.02;

  /// Prepares `scene` for workspaces that are made after this, so that friction can be added to it. `scene` must
  /// outlive the object and be stepped by no other workspace.
  explicit SceneTuner(runtime::CompiledScene& scene);
  /// Call it before each step, in the thread of the steps. No allocation.
  void tune(const view::SettingWishes& wishes) noexcept;

 private:
  runtime::CompiledScene& scene_;
  const runtime::Coupling coupling_;    // as the scene says
  const double rotation_, turning_;     // stiffness and damping of the rotation, for 1 of the translation [mm^2/rad]
  const std::vector<double> friction_;  // (objects) as the scene says
  double friction_wish_ = std::numeric_limits<double>::quiet_NaN();
  bool rubs_otherwise_ = true;  // than wished, or unknown
};

}  // namespace spheretree::player

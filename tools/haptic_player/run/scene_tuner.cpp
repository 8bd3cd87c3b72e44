// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/scene_tuner.h"

#include <cmath>

namespace spheretree::player {
namespace {

/// Moves `value` towards the wish, or towards `scene` without one (NaN); the rest of the way is done at once below
/// `least`. Returns whether it moved.
bool moveTowards(double wish, double scene, double least, double& value) noexcept {
  const double goal = std::isnan(wish) ? scene : wish;
  if (value == goal) return false;
  value = std::abs(goal - value) > least ? value + SceneTuner::kShare * (goal - value) : goal;
  return true;
}

std::vector<double> frictionOf(const runtime::CompiledScene& scene) {
  std::vector<double> friction;
  for (const runtime::CompiledObject& object : scene.objects) friction.push_back(object.friction);
  return friction;
}

}  // namespace

SceneTuner::SceneTuner(runtime::CompiledScene& scene)
    : scene_(scene),
      coupling_(scene.coupling),
      rotation_(coupling_.rotation / coupling_.translation),
      turning_(coupling_.damping > 0 ? coupling_.rotation_damping / coupling_.damping : rotation_),
      friction_(frictionOf(scene)) {
  scene_.has_friction = true;  // until the first tune()
}

void SceneTuner::tune(const view::SettingWishes& wishes) noexcept {
  const double stiffness = wishes.stiffness.load(std::memory_order_relaxed), damping = wishes.damping.load(std::memory_order_relaxed),
               rubbing = wishes.friction.load(std::memory_order_relaxed);
  runtime::Coupling coupling = scene_.coupling;
  const bool is_stiffer = moveTowards(stiffness, coupling_.translation, 1e-4 * coupling_.translation, coupling.translation);
  const bool is_damped = moveTowards(damping, coupling_.damping, 1e-6 * coupling_.translation, coupling.damping);
  if (is_stiffer) coupling.rotation = coupling.translation == coupling_.translation ? coupling_.rotation : rotation_ * coupling.translation;
  if (is_damped)
    coupling.rotation_damping = coupling.damping == coupling_.damping ? coupling_.rotation_damping : turning_ * coupling.damping;
  if (is_stiffer || is_damped) scene_.couple(coupling);

  const bool is_same = rubbing == friction_wish_ || (std::isnan(rubbing) && std::isnan(friction_wish_));
  if (is_same && !rubs_otherwise_) return;
  friction_wish_ = rubbing;
  scene_.has_friction = rubs_otherwise_ = false;
  for (std::size_t i = 0; i < friction_.size(); ++i) {
    double& friction = scene_.objects[i].friction;
    rubs_otherwise_ = moveTowards(rubbing, friction_[i], 1e-4, friction) || rubs_otherwise_;
    scene_.has_friction = scene_.has_friction || friction > 0;
  }
}

}  // namespace spheretree::player

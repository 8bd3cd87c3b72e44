// SPDX-License-Identifier: GPL-3.0-or-later
#include "model/removal.h"

#include <algorithm>
#include <limits>

namespace spheretree::view {

using Eigen::Vector3d;

Removal::Removal(const Stage& stage) : stage_(&stage) {
  double smallest = std::numeric_limits<double>::infinity();
  for (const spheretree::Ball& ball : stage.burr) smallest = std::min(smallest, ball.radius);
  if (stage.burr.empty()) return;
  for (std::size_t i = 0; i < stage.objects.size(); ++i)
    if (stage.objects[i].cut) objects_.push_back({i, CutSurface(stage.objects[i].cut, smallest), {}, {}});
}

void Removal::add(const player::RecordedStep& step, std::span<const Configuration> carriers) {
  const Configuration& tool = step.graphic;
  std::vector<Vector3d> now(stage_->burr.size());
  for (Object& object : objects_) {
    const Configuration back = inverse(poseOf(stage_->objects[object.index], carriers));
    for (std::size_t k = 0; k < now.size(); ++k) {
      const Vector3d in_world = tool.position + tool.orientation * (stage_->burr[k].centre - stage_->reference_point);
      now[k] = back.position + back.orientation * in_world;
    }
    const auto removeTo = [&](const std::vector<Vector3d>& end) {
      for (std::size_t k = 0; k < now.size(); ++k) object.surface.remove(object.removed_to[k], end[k], stage_->burr[k].radius);
      object.removed_to = end;
    };
    if (has_before_ && step.spins && !was_spinning_) {
      object.removed_to = object.before;
      removeTo(now);
    } else if (has_before_ && step.spins) {
      const double unseen = object.surface.spacing() / 8;
      double farthest = 0;
      for (std::size_t k = 0; k < now.size(); ++k) farthest = std::max(farthest, (now[k] - object.removed_to[k]).norm());
      if (farthest > unseen) removeTo(now);
    } else if (was_spinning_) {
      removeTo(object.before);
    }
    object.before = now;
  }
  was_spinning_ = has_before_ && step.spins;
  has_before_ = true;
}

const CutSurface* Removal::of(std::size_t object) const {
  for (const Object& each : objects_)
    if (each.index == object) return &each.surface;
  return nullptr;
}

}  // namespace spheretree::view

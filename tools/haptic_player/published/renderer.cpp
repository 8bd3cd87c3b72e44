// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/renderer.h"

#include <stdexcept>

#include "step/coupling_wrench.h"

namespace spheretree::player {

Renderer::Renderer(const RendererScene& scene) : coupling_(scene.coupling) {
  for (const PlacedBody& object : scene.objects) poses_.push_back(object.pose);
}

Renderer::Renderer(const runtime::SceneDescription& scene) : coupling_(scene.coupling) {
  for (const runtime::SceneObject& object : scene.objects) poses_.push_back(object.pose);
}

runtime::StepResult Renderer::step(const Configuration& haptic) {
  if (!is_started_) graphic_ = haptic;
  is_started_ = true;
  runtime::StepResult result;
  result.pairs = result.rows = result.active = follow(haptic);
  result.graphic = graphic_;
  result.wrench = result.limited_wrench = runtime::couplingWrench(coupling_, haptic, graphic_);
  return result;
}

std::unique_ptr<Renderer> makeRenderer(Mode mode, const RendererScene& scene) {
  if (mode == Mode::Points) return makePointsRenderer(scene);
  if (mode == Mode::Volume) return makeVolumeRenderer(scene);
  if (mode == Mode::Continuous) return makeContinuousRenderer(scene);
  throw std::invalid_argument("our own modes are rendered by the runtime");
}

}  // namespace spheretree::player

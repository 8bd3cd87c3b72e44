// SPDX-License-Identifier: GPL-3.0-or-later
#include "published/renderer.h"

#include <stdexcept>

#include "published/renderer_kinds.h"

namespace spheretree::player {

std::unique_ptr<Renderer> makeRenderer(Mode mode, const RendererScene& scene) {
  if (mode == Mode::Points) return makePointsRenderer(scene);
  if (mode == Mode::Volume) return makeVolumeRenderer(scene);
  if (mode == Mode::Continuous) return makeContinuousRenderer(scene);
  throw std::invalid_argument("our own modes are rendered by the runtime");
}

}  // namespace spheretree::player

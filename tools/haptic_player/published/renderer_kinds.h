// SPDX-License-Identifier: GPL-3.0-or-later
// The published renderers, each in a file of its own.
#pragma once

#include "published/renderer.h"

namespace spheretree::player {

std::unique_ptr<Renderer> makePointsRenderer(const RendererScene& scene);
std::unique_ptr<Renderer> makeVolumeRenderer(const RendererScene& scene);
std::unique_ptr<Renderer> makeContinuousRenderer(const RendererScene& scene);

}  // namespace spheretree::player

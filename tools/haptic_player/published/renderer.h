// SPDX-License-Identifier: GPL-3.0-or-later
// What a published renderer is to the bench: a haptic pose in, the pose of the graphic tool and the wrench out.
// Three of them: points_renderer.cpp, volume_renderer.cpp, continuous_renderer.cpp. They are written after their papers
// to be compared with, in this program only; docs/renderers.md says with which settings.
// Units: mm, N, N mm, rad.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "published/mode.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::player {

struct Body;
struct PlacedBody;

/// What it renders, and within how much memory.
struct RendererScene {
  const Body* tool = nullptr;
  Eigen::Vector3d reference_point = Eigen::Vector3d::Zero();  // mesh frame of the tool
  std::vector<PlacedBody> objects;
  runtime::Coupling coupling;
  std::size_t bytes = 0;  // for all models together; ours gets the same
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  /// One servo step. The first one, and the first after restart(), puts the graphic tool at the haptic pose.
  virtual runtime::StepResult step(const Configuration& haptic) = 0;
  virtual void restart() = 0;
  /// Mesh frame of an object in the world.
  virtual void moveObject(std::size_t object, const Configuration& pose) = 0;
};

/// `mode`: one that is not ours.
std::unique_ptr<Renderer> makeRenderer(Mode mode, const RendererScene& scene);

}  // namespace spheretree::player

// SPDX-License-Identifier: GPL-3.0-or-later
// The interface of a published renderer in the comparison: a haptic pose in, the pose of the graphic tool and the
// wrench out. There are four: points_renderer.cpp, volume_renderer.cpp, continuous_renderer.cpp and, for drilling,
// voxel_renderer.cpp. They are implemented after their papers, for comparison and in this program only;
// docs/renderers.md lists their settings.
// Units: mm, N, N mm, rad.
#pragma once

#include <cstddef>
#include <memory>
#include <vector>

#include "bodies/scenario_shapes.h"
#include "published/mode.h"
#include "spheretree/runtime/scene.h"

namespace spheretree::player {

/// The scene of a renderer, and its memory.
struct RendererScene {
  const Body* tool = nullptr;
  Eigen::Vector3d reference_point = Eigen::Vector3d::Zero();  // mesh frame of the tool
  std::vector<PlacedBody> objects;
  runtime::Coupling coupling;
  std::size_t bytes = 0;  // for all models together; our runtime gets the same
};

/// From the tool's own axes, relative to its reference point, to the mesh frame of an object.
struct ToObject {
  Quaternion turn;
  Eigen::Vector3d shift;
  ToObject(const Configuration& tool, const Configuration& object)
      : turn((object.orientation.conjugate() * tool.orientation).normalized()),
        shift(object.orientation.conjugate() * (tool.position - object.position)) {}
  Eigen::Vector3d operator()(const Eigen::Vector3d& p) const { return turn * p + shift; }
};

class Renderer {
 public:
  virtual ~Renderer() = default;
  /// Computes one servo step. The first one, and the first after restart(), puts the graphic tool at the haptic pose.
  runtime::StepResult step(const Configuration& haptic);
  virtual void restart() { is_started_ = false; }
  /// `pose`: mesh frame of the object in the world.
  void moveObject(std::size_t object, const Configuration& pose) { poses_[object] = pose; }

 protected:
  explicit Renderer(const RendererScene& scene);
  explicit Renderer(const runtime::SceneDescription& scene);
  /// Moves graphic_ towards the hand; returns the number of contacts.
  virtual std::uint32_t follow(const Configuration& haptic) = 0;

  const runtime::Coupling coupling_;
  std::vector<Configuration> poses_;  // of the objects
  Configuration graphic_;

 private:
  bool is_started_ = false;
};

/// `mode` must not be one of our runtime's.
std::unique_ptr<Renderer> makeRenderer(Mode mode, const RendererScene& scene);
std::unique_ptr<Renderer> makePointsRenderer(const RendererScene& scene);
std::unique_ptr<Renderer> makeVolumeRenderer(const RendererScene& scene);
std::unique_ptr<Renderer> makeContinuousRenderer(const RendererScene& scene);

}  // namespace spheretree::player

// SPDX-License-Identifier: GPL-3.0-or-later
#include "body_paths.h"

#include <algorithm>
#include <cmath>

#include "spheretree/formats/trajectory.h"

namespace spheretree::player {

BodyPaths::BodyPaths(const formats::SceneFile& scene, const std::filesystem::path& scene_path) {
  for (const formats::SceneBody& body : scene.bodies) {
    Path path;
    if (body.hinge)
      path.hinge = *body.hinge;
    else
      path.poses = formats::readTrajectory(formats::scenePath(scene_path, body.pose_csv));
    bodies_.push_back(std::move(path));
  }
}

Configuration BodyPaths::at(std::size_t body, double t) const noexcept {
  const Path& path = bodies_[body - 1];
  if (path.poses.empty()) return formats::hingePose(path.hinge, t);
  const double last = static_cast<double>(path.poses.size() - 1);
  return path.poses[static_cast<std::size_t>(std::clamp(std::round(1000 * t), 0.0, last))];
}

void BodyPaths::moveTo(double t, runtime::Workspace& workspace) const noexcept {
  for (std::size_t body = 1; body <= bodies_.size(); ++body)
    runtime::moveBody(static_cast<std::uint32_t>(body), at(body, t), workspace);  // one that carries nothing is not known there
}

BodyPaths readBodyPaths(const std::filesystem::path& scene) {
  return scene.empty() ? BodyPaths() : BodyPaths(formats::readScene(scene), scene);
}

std::uint32_t bodyNumber(const formats::SceneFile& scene, const std::string& name) {
  for (std::size_t i = 0; i < scene.bodies.size(); ++i)
    if (scene.bodies[i].name == name) return static_cast<std::uint32_t>(i + 1);
  return 0;
}

}  // namespace spheretree::player

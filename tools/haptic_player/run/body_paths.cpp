// SPDX-License-Identifier: GPL-3.0-or-later
#include "run/body_paths.h"

#include <algorithm>
#include <utility>

namespace spheretree::player {

BodyPaths::BodyPaths(const formats::SceneFile& file, const std::filesystem::path& scene_path) {
  for (scene::BodyPath& read : scene::readBodyPaths(file, scene_path)) {
    Path path{{std::move(read)}};
    if (path.poses.empty() && hinged_.size() < kMaxHinges) {
      path.number = hinged_.size();
      const auto [low, high] = std::minmax_element(path.hinge.angles.begin(), path.hinge.angles.end(),
                                                   [](const auto& a, const auto& b) { return a.degree < b.degree; });
      hinged_.push_back({file.bodies[bodies_.size()].name, low->degree, high->degree});
    }
    bodies_.push_back(std::move(path));
  }
}

HingeAngles BodyPaths::anglesAt(double t) const noexcept {
  HingeAngles angles{};
  for (const Path& path : bodies_)
    if (path.number < kMaxHinges) angles[path.number] = formats::hingeAngle(path.hinge, t);
  return angles;
}

Configuration BodyPaths::at(std::size_t body, double t, const HingeAngles& angles) const noexcept {
  const Path& path = bodies_[body - 1];
  return path.number < kMaxHinges ? formats::hingePose(path.hinge, angles[path.number]) : path.at(t);
}

void BodyPaths::moveTo(double t, const HingeAngles& angles, runtime::Workspace& workspace) const noexcept {
  for (std::size_t body = 1; body <= bodies_.size(); ++body)
    runtime::moveBody(static_cast<std::uint32_t>(body), at(body, t, angles),
                      workspace);  // a body without objects is unknown to the runtime
}

std::vector<Configuration> BodyPaths::posesAt(double t, const HingeAngles& angles) const {
  std::vector<Configuration> poses;
  for (std::size_t body = 1; body <= bodies_.size(); ++body) poses.push_back(at(body, t, angles));
  return poses;
}

BodyPaths readBodyPaths(const std::filesystem::path& scene) {
  return scene.empty() ? BodyPaths() : BodyPaths(formats::readScene(scene), scene);
}

}  // namespace spheretree::player

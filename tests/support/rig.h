// SPDX-License-Identifier: Apache-2.0
// A scene to step through, for tests in which it must compile.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "spheretree/runtime/step.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

namespace spheretree::test {

inline const Quaternion kUpright(1, 0, 0, 0);

inline double degreesBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b)) * 180 / M_PI;
}

inline constexpr std::array kSpeeds{0.05, 0.5, 1.0, 2.0, 50.0};  // [mm] a step: 0.05 to 2 m/s, and one jump

inline runtime::SceneDescription toolAndObject(SphereTree tool, SphereTree object, const Configuration& at = {}) {
  runtime::SceneDescription d;
  d.tool = std::move(tool);
  d.objects.push_back({std::move(object), at});
  return d;
}

/// A plate of 60 x 60 mm about z = 0 whose leaves are far thicker than its skin.
inline SphereTree thinPlate(double thickness, bool has_skin = true) {
  const SphereTree leaves = boxTree({30, 30, 0}, {40, 40, 1}, has_skin ? 1.2 : thickness / 2 + 0.6);
  return has_skin ? withSkin(leaves, boxSkin({30, 30, thickness / 2})) : leaves;
}

struct Rig {
  runtime::SceneDescription description;
  runtime::Scene scene;
  std::unique_ptr<runtime::Workspace> workspace;
  runtime::Mode mode = runtime::Mode::Constrained;

  explicit Rig(runtime::SceneDescription d) : description(std::move(d)) {
    std::string fault;
    EXPECT_TRUE(runtime::compileScene(description, scene, fault)) << fault;
    workspace = std::make_unique<runtime::Workspace>(scene);
  }
  Rig(SphereTree tool, SphereTree object, const Configuration& at = {}) : Rig(toolAndObject(std::move(tool), std::move(object), at)) {}

  runtime::StepResult to(const Configuration& haptic) { return runtime::step(scene, haptic, mode, *workspace); }
  runtime::StepResult toPoint(const Eigen::Vector3d& position, const Quaternion& turn = kUpright) {
    return to(Configuration{position, turn});
  }
};

}  // namespace spheretree::test

// SPDX-License-Identifier: GPL-3.0-or-later
// Mass and inertia tensor of a link as a simulator accepts them. URDFs leave them out, set them to 0, or have tensors
// that belong to no solid body; MuJoCo refuses such a model.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "robot/cover/robot_cover.h"
#include "robot/model/robot_model.h"

namespace spheretree::robot {

struct BodyInertia {
  double mass = 0;                                   // [kg], > 0
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();  // of mass, in the link [mm]
  Eigen::Matrix3d tensor;                            // about the centre, along the axes of the link [kg m^2]; of a solid body
  std::string change;                                // what differs from the URDF, and why; empty if nothing does
};

/// Empty for a link without a mass that does not need one, because no joint moves it.
/// A moving link without a mass gets 1 g. A tensor whose moments a <= b <= c no solid body can have (0 < a, a + b >= c)
/// keeps its axes and c, and b and a are raised as far as necessary; one without a positive moment becomes that of a
/// box around the spheres.
std::optional<BodyInertia> bodyInertia(const Link& link, bool is_moved, std::span<const MetreSphere> spheres);

}  // namespace spheretree::robot

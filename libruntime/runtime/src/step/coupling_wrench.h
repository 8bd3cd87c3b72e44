// SPDX-License-Identifier: Apache-2.0
// The wrench of the spring between the haptic tool and the graphic tool, as the hand feels it.
#pragma once

#include "spheretree/runtime/scene.h"

namespace spheretree::runtime {

/// Acts on the hand, towards the graphic tool: stiffness times (graphic - haptic), with the rotation as a rotation
/// vector of length [0, pi]. About the reference point of the haptic tool, world axes.
Wrench couplingWrench(const Coupling& coupling, const Configuration& haptic, const Configuration& graphic) noexcept;

/// The wrench reduced to the limits, with unchanged directions of force and torque. A wrench that is not finite becomes
/// zero.
Wrench limited(const Wrench& wrench, const WrenchLimits& limits) noexcept;

}  // namespace spheretree::runtime

// SPDX-License-Identifier: Apache-2.0
// How the virtual tool is attached to the handle, and the pose of the device in the world of the scene.
#pragma once

#include "spheretree/core/rigid.h"

namespace spheretree::device {

struct ToolMount {
  Configuration device_in_world;      // origin and axes of the device frame (+x right, +y up, +z to the user), in the world
  Configuration reference_in_handle;  // reference point and axes of the tool, in the frame of the handle
};

/// The haptic tool in the world, for a handle in the device frame.
Configuration toolInWorld(const ToolMount& mount, const Configuration& handle) noexcept;

/// The handle in the device frame, for a haptic tool in the world: the inverse of toolInWorld().
Configuration handleOf(const ToolMount& mount, const Configuration& tool) noexcept;

/// The wrench that the device must render at the handle so that `wrench` acts on the tool. `wrench` is in world axes,
/// about the reference point of the tool. A force at a distance from the handle causes a torque there.
Wrench wrenchOnHandle(const ToolMount& mount, const Configuration& handle, const Wrench& wrench) noexcept;

}  // namespace spheretree::device

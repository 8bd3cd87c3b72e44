// SPDX-License-Identifier: Apache-2.0
// How the virtual tool sits on the handle, and the device in the world of the scene.
#pragma once

#include "spheretree/core/rigid.h"

namespace spheretree::device {

struct ToolMount {
  Configuration device_in_world;      // origin and axes of the device frame (+x right, +y up, +z to the user), in the world
  Configuration reference_in_handle;  // reference point and axes of the tool, seen from the handle
};

/// The haptic tool in the world, of a handle in the device frame.
Configuration toolInWorld(const ToolMount& mount, const Configuration& handle) noexcept;

/// The handle in the device frame, of a haptic tool in the world: the inverse of toolInWorld().
Configuration handleOf(const ToolMount& mount, const Configuration& tool) noexcept;

/// What the device must render at the handle, so that the tool feels `wrench`: world axes, about the reference point of
/// the tool. The force at a point away from the handle is a torque there.
Wrench wrenchOnHandle(const ToolMount& mount, const Configuration& handle, const Wrench& wrench) noexcept;

}  // namespace spheretree::device

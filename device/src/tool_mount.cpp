// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/tool_mount.h"

namespace spheretree::device {

Configuration toolInWorld(const ToolMount& mount, const Configuration& handle) noexcept {
  return composed(mount.device_in_world, composed(handle, mount.reference_in_handle));
}

Configuration handleOf(const ToolMount& mount, const Configuration& tool) noexcept {
  return composed(inverse(mount.device_in_world), composed(tool, inverse(mount.reference_in_handle)));
}

Wrench wrenchOnHandle(const ToolMount& mount, const Configuration& handle, const Wrench& wrench) noexcept {
  const Eigen::Vector3d reference = toolInWorld(mount, handle).position;
  const Eigen::Vector3d grip = composed(mount.device_in_world, handle).position;
  const Wrench there = wrenchAbout(wrench, reference, grip);
  const Quaternion to_device = mount.device_in_world.orientation.conjugate();
  return {to_device * there.force, to_device * there.torque};
}

}  // namespace spheretree::device

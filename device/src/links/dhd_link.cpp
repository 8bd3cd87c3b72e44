// SPDX-License-Identifier: Apache-2.0
#include "links/dhd_link.h"

#include <limits>
#include <optional>

#include "links/nearest_rotation.h"

namespace spheretree::device {
namespace {

constexpr double kDhdUnit = 1000;  // [mm/m]

/// The vendor's frame is +x to the user, +y right, +z up.
Eigen::Matrix3d fromVendor() { return (Eigen::Matrix3d() << 0, 1, 0, 0, 0, 1, 1, 0, 0).finished(); }

}  // namespace

DhdLink::DhdLink(const std::string& library) : api_(loadDhdApi(library)) {
  const int id = api_.dhdOpenID(0);
  if (id < 0)
    throw DeviceError(DeviceFault::NotFound, "no Force Dimension device: " + lastError() +
                                                 ". Check power and cable, and the rights to the USB device (the SDK has a udev rule)");
  id_ = static_cast<char>(id);
  has_wrist_ = api_.dhdHasActiveWrist(id_);
}

DhdLink::~DhdLink() { api_.dhdClose(id_); }

DeviceInfo DhdLink::info() const {
  DeviceInfo info;
  const char* name = api_.dhdGetSystemName(id_);
  info.model = name && *name ? name : "Force Dimension device";
  info.driver = "Force Dimension SDK";
  info.renders_torque = has_wrist_;
  info.can_step = false;
  return info;
}

void DhdLink::begin() {
  if (api_.dhdSetGravityCompensation(kDhdOn, id_) < 0 || api_.dhdEnableForce(kDhdOn, id_) < 0)
    throw DeviceError(DeviceFault::Communication,
                      "the Force Dimension device does not start: " + lastError() + ". Switch it off and on, and try again");
}

bool DhdLink::read(LinkState& state) noexcept {
  double p[3] = {}, matrix[3][3] = {};
  const int result = failed_ != 0 ? failed_ : api_.dhdGetPositionAndOrientationFrame(&p[0], &p[1], &p[2], matrix, id_);
  if (result < 0) failed_ = result;
  state.failed = failed_ != 0;
  state.code = failed_ != 0 ? failed_ : warning_;
  if (state.failed) return false;
  const Eigen::Matrix3d axes = fromVendor(), r = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(&matrix[0][0]);
  state.handle.position = kDhdUnit * (axes * Eigen::Vector3d(p));
  if (const std::optional<Quaternion> rotation = nearestRotation(axes * r * axes.transpose()))
    state.handle.orientation = *rotation;
  else
    state.handle.position.setConstant(std::numeric_limits<double>::quiet_NaN());
  state.buttons = api_.dhdGetButtonMask(id_);
  return true;
}

void DhdLink::send(const Wrench& wrench) noexcept {
  const Eigen::Matrix3d axes = fromVendor();
  const Eigen::Vector3d f = axes.transpose() * wrench.force;
  const Eigen::Vector3d t = has_wrist_ ? Eigen::Vector3d(axes.transpose() * wrench.torque / kDhdUnit) : Eigen::Vector3d::Zero();
  const int result = api_.dhdSetForceAndTorqueAndGripperForce(f.x(), f.y(), f.z(), t.x(), t.y(), t.z(), 0, id_);
  if (result < 0) failed_ = result;
  if (result == kDhdMotorSaturated) warning_ = result;
}

void DhdLink::end() noexcept { api_.dhdEnableForce(kDhdOff, id_); }

std::string DhdLink::lastError() const {
  const char* words = api_.dhdErrorGetLastStr();
  return words ? words : "it does not say why";
}

}  // namespace spheretree::device

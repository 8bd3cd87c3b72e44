// SPDX-License-Identifier: Apache-2.0
#include "spheretree/device/phantom_device.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <thread>
#include <vector>

#include "links/hd_api.h"
#include "links/nearest_rotation.h"

namespace spheretree::device {
namespace {

constexpr int kZerosToStop = 3;                   // servo steps with zero wrench before the scheduler is stopped
constexpr int kMaxErrors = 32;                    // read in one call; a broken driver may report errors without end
constexpr double kMaxTorque[3] = {188, 188, 48};  // the library reports no limit: that of its own example [N mm]

/// `transform`: column-major, millimetres. Not finite if the matrix is far from any rotation.
Configuration poseOf(const double (&transform)[16]) noexcept {
  const Eigen::Map<const Eigen::Matrix4d> matrix(transform);
  Configuration pose;
  pose.position = matrix.topRightCorner<3, 1>();
  if (const std::optional<Quaternion> rotation = nearestRotation(matrix.topLeftCorner<3, 3>()))
    pose.orientation = *rotation;
  else
    pose.position.setConstant(std::numeric_limits<double>::quiet_NaN());
  return pose;
}

/// Torques of the joints: the components along each axis in the current pose of the joints. The roll axis is the
/// handle's z axis; the pitch and yaw axes precede it.
Eigen::Vector3d gimbalTorque(const Quaternion& handle, const double (&angles)[3], const Eigen::Vector3d& torque) noexcept {
  const Quaternion before_roll = handle * rotationOf({0, 0, -angles[2]});
  const Quaternion before_pitch = before_roll * rotationOf({-angles[1], 0, 0});
  return {(before_pitch * Eigen::Vector3d::UnitY()).dot(torque), (before_roll * Eigen::Vector3d::UnitX()).dot(torque),
          (handle * Eigen::Vector3d::UnitZ()).dot(torque)};
}

}  // namespace

PhantomDevice::PhantomDevice(const PhantomSettings& settings)
    : api_(&loadHdApi(settings.library)), settings_(settings), handle_(kHdInvalidHandle) {
  openDevice();
  try {
    readInfo();
    checkCalibration();
  } catch (...) {
    api_->hdDisableDevice(handle_);
    throw;
  }
}

PhantomDevice::~PhantomDevice() {
  stop();
  api_->hdDisableDevice(handle_);
}

void PhantomDevice::openDevice() {
  if (!settings_.vendor.empty() &&
      !api_->hdDeploymentLicense(settings_.vendor.c_str(), settings_.application.c_str(), settings_.password.c_str()))
    throw DeviceError(DeviceFault::Refused, "the deployment licence of OpenHaptics is refused: " + drain());
  const std::vector<const char*> names = settings_.device.empty() ? std::vector<const char*>{nullptr, "Default PHANToM", "Default Device"}
                                                                  : std::vector<const char*>{settings_.device.c_str()};
  std::string tried;
  for (const char* name : names) {
    handle_ = api_->hdInitDevice(name);
    const std::string errors = drain();
    if (handle_ != kHdInvalidHandle && errors.empty()) return;
    if (handle_ != kHdInvalidHandle) api_->hdDisableDevice(handle_);
    if (!tried.empty()) tried += "; ";
    tried.append(name ? name : "first device").append(": ").append(errors.empty() ? "no handle" : errors);
  }
  throw DeviceError(
      DeviceFault::NotFound,
      "no Phantom: " + tried +
          ". Check power, cable, the rights to its device file, and its name in the vendor's setup. A Touch without a serial port "
          "needs TouchDriver 2023 or later, whose setup program needs the Qt that comes with it");
}

void PhantomDevice::readInfo() {
  api_->hdMakeCurrentDevice(handle_);
  const auto text = [&](HdEnum what) {
    const char* found = api_->hdGetString(what);
    return drain().empty() && found ? std::string(found) : std::string();
  };
  info_.model = text(kHdDeviceModelType);
  if (info_.model.empty()) info_.model = "Phantom";
  info_.serial = text(kHdDeviceSerialNumber);
  info_.driver = "OpenHaptics, driver " + text(kHdDeviceDriverVersion);
  info_.can_step = false;
  std::int32_t degrees = 0;
  api_->hdGetIntegerv(kHdOutputDof, &degrees);
  info_.renders_torque = degrees >= 6;
  double largest = 0, continuous = 0;
  api_->hdGetDoublev(kHdNominalMaxForce, &largest);
  api_->hdGetDoublev(kHdNominalMaxContinuousForce, &continuous);
  if (const std::string errors = drain(); !errors.empty())
    throw DeviceError(DeviceFault::Communication, info_.model + " does not answer: " + errors);
  if (!(largest > 0) || !(continuous > 0))
    throw DeviceError(DeviceFault::Communication, info_.model + " states no force limit: reinstall its driver");
  info_.max_force = largest;
  info_.continuous_force = continuous;
  info_.max_torque = info_.continuous_torque = Eigen::Vector3d(kMaxTorque);
  double temperatures[6];
  std::uint8_t held;
  has_temperature_ = accepted([&] { api_->hdGetDoublev(kHdMotorTemperature, temperatures); });
  has_switch_ = accepted([&] { api_->hdGetBooleanv(kHdCurrentSafetySwitch, &held); });
}

void PhantomDevice::checkCalibration() {
  std::int32_t styles = 0;
  api_->hdGetIntegerv(kHdCalibrationStyle, &styles);
  const auto calibrated = [&] { return api_->hdCheckCalibration() == kHdCalibrationOk; };
  if (!calibrated()) {
    if (styles & kHdCalibrationAuto)
      api_->hdUpdateCalibration(kHdCalibrationAuto);
    else if ((styles & kHdCalibrationEncoderReset) && settings_.calibrate)
      api_->hdUpdateCalibration(kHdCalibrationEncoderReset);
    if (!calibrated())
      throw DeviceError(DeviceFault::NotCalibrated,
                        info_.model + " is not calibrated: " +
                            (styles & kHdCalibrationEncoderReset ? "put the arm into its reset pose (all links at right angles) and open "
                                                                   "it with `calibrate` (haptic-player: --hd-calibrate)"
                             : styles & kHdCalibrationInkwell    ? "put the stylus into its inkwell and try again"
                                                                 : "move the handle through its workspace and try again"));
  }
  if (const std::string errors = drain(); !errors.empty())
    throw DeviceError(DeviceFault::NotCalibrated, info_.model + ": calibration: " + errors);
}

/// The forces become active with the scheduler, which is therefore started last.
void PhantomDevice::begin(Clock) {
  quit_ = false;
  zeros_sent_ = 0;
  failed_ = interrupted_ = warm_ = switch_seen_ = false;
  api_->hdMakeCurrentDevice(handle_);
  // The library's own clamp and ramp are additional protection: not every model has them.
  accepted([&] { api_->hdEnable(kHdMaxForceClamping); });
  accepted([&] { api_->hdEnable(kHdForceRamping); });
  api_->hdEnable(kHdForceOutput);
  api_->hdSetSchedulerRate(static_cast<unsigned long>(std::lround(1 / period())));
  callback_ = api_->hdScheduleAsynchronous(&PhantomDevice::onServo, this, kHdMaxPriority);
  std::string errors = drain();
  if (errors.empty()) {
    api_->hdStartScheduler();
    errors = drain();
    if (errors.empty()) return;
    end();
  } else {
    api_->hdUnschedule(callback_);
    drain();
  }
  throw DeviceError(DeviceFault::Communication, info_.model + " does not start: " + errors + ". Switch it off and on, and try again");
}

void PhantomDevice::end() noexcept {
  quit_ = true;                  // from now on the servo step sends zero, then ends
  constexpr int kLongest = 100;  // time limit for a scheduler that no longer runs [ms]
  for (int n = 0; n < kLongest && api_->hdWaitForCompletion(callback_, kHdWaitCheckStatus); ++n)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  api_->hdStopScheduler();
  api_->hdUnschedule(callback_);
  for (int n = 0; n < kMaxErrors && api_->hdGetError().code != 0; ++n) {
  }
}

std::uint32_t PhantomDevice::onServo(void* self) noexcept { return static_cast<PhantomDevice*>(self)->servo(); }

std::uint32_t PhantomDevice::servo() noexcept {
  api_->hdBeginFrame(handle_);
  const bool leaving = quit_.load(std::memory_order_relaxed);
  DeviceState state;
  Wrench wrench;
  if (!leaving) {
    state = measured();
    wrench = tick(state);
  }
  send(wrench);
  api_->hdEndFrame(handle_);
  drainInServo();
  // After a fault zero is sent several more times: without a new frame the amplifiers might keep the last command.
  if (leaving || state.failed) ++zeros_sent_;
  return zeros_sent_ >= kZerosToStop ? kHdCallbackDone : kHdCallbackContinue;
}

DeviceState PhantomDevice::measured() noexcept {
  DeviceState state;
  double transform[16] = {}, temperatures[6] = {};
  std::int32_t buttons = 0;
  std::uint8_t held = 0;
  api_->hdGetDoublev(kHdCurrentTransform, transform);
  api_->hdGetIntegerv(kHdCurrentButtons, &buttons);
  if (has_switch_) api_->hdGetBooleanv(kHdCurrentSafetySwitch, &held);
  if (has_temperature_) api_->hdGetDoublev(kHdMotorTemperature, temperatures);
  state.handle = poseOf(transform);
  state.buttons = static_cast<std::uint32_t>(buttons);
  // A device without a safety switch always reports 0: only a switch that was on before can be released.
  switch_seen_ = switch_seen_ || held != 0;
  state.released = interrupted_ || (switch_seen_ && held == 0);
  state.temperature = warm_ ? 1 : *std::max_element(std::begin(temperatures), std::end(temperatures));
  state.failed = failed_;
  interrupted_ = warm_ = false;
  return state;
}

void PhantomDevice::send(const Wrench& wrench) noexcept {
  api_->hdSetDoublev(kHdCurrentForce, wrench.force.data());
  if (!info_.renders_torque) return;
  if (settings_.torque == TorqueConvention::Cartesian) {
    api_->hdSetDoublev(kHdCurrentTorque, wrench.torque.data());
    return;
  }
  double angles[3] = {}, transform[16] = {};
  api_->hdGetDoublev(kHdCurrentGimbalAngles, angles);
  api_->hdGetDoublev(kHdCurrentTransform, transform);
  const Eigen::Vector3d torque = gimbalTorque(poseOf(transform).orientation, angles, wrench.torque);
  api_->hdSetDoublev(kHdCurrentGimbalTorque, torque.data());
}

/// Force errors (too warm, too strong, too fast, a kick) switch the amplifiers off; they come back by themselves, so
/// guard and ramp start again. After any other error the state of the device is unknown: zero for the rest of this run.
void PhantomDevice::drainInServo() noexcept {
  for (int n = 0; n < kMaxErrors; ++n) {
    const HdErrorInfo error = api_->hdGetError();
    if (error.code == 0) return;
    if (error.code >= kHdErrorForceFirst && error.code <= kHdErrorForceLast) {
      interrupted_ = true;
      warm_ = warm_ || error.code == kHdErrorWarmMotors;
      note(static_cast<std::int32_t>(error.code));
    } else {
      failed_ = true;
      finish(Phase::Failed, DeviceFault::Communication, static_cast<std::int32_t>(error.code));
    }
  }
}

/// True if the call left no error: models refuse functions that they do not have.
bool PhantomDevice::accepted(const std::function<void()>& call) const {
  call();
  return drain().empty();
}

/// All pending errors in the vendor's words and numbers; empty if there are none.
std::string PhantomDevice::drain() const {
  std::string all;
  for (int n = 0; n < kMaxErrors; ++n) {
    const HdErrorInfo error = api_->hdGetError();
    if (error.code == 0) break;
    const char* words = api_->hdGetErrorString(error.code);
    char numbers[64];
    std::snprintf(numbers, sizeof numbers, " (0x%04x, internal %d)", error.code, error.internal);
    if (!all.empty()) all += ", ";
    all.append(words ? words : "error").append(numbers);
  }
  return all;
}

}  // namespace spheretree::device

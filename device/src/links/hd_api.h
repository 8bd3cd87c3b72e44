// SPDX-License-Identifier: Apache-2.0
// The part of HDAPI that we call: declarations of our own, written from its documented interface.
#pragma once

#include <cstdint>
#include <string>

namespace spheretree::device {

using HdHandle = std::uint32_t;
using HdEnum = std::uint32_t;
using HdCallback = std::uint32_t (*)(void*);

struct HdErrorInfo {
  std::uint32_t code;
  std::int32_t internal;
  HdHandle device;
};
static_assert(sizeof(HdErrorInfo) == 12);

inline constexpr HdHandle kHdInvalidHandle = 0xffffffff;
enum : HdEnum {
  kHdCurrentButtons = 0x2000,
  kHdCurrentSafetySwitch = 0x2001,
  kHdCurrentTransform = 0x2052,
  kHdCurrentGimbalAngles = 0x2150,
  kHdDeviceModelType = 0x2501,
  kHdDeviceDriverVersion = 0x2502,
  kHdDeviceSerialNumber = 0x2504,
  kHdOutputDof = 0x2554,
  kHdCalibrationStyle = 0x2555,
  kHdNominalMaxForce = 0x2603,
  kHdNominalMaxContinuousForce = 0x2604,
  kHdMotorTemperature = 0x2605,
  kHdCurrentForce = 0x2700,
  kHdCurrentTorque = 0x2701,
  kHdCurrentGimbalTorque = 0x2704,
  kHdForceOutput = 0x4000,
  kHdMaxForceClamping = 0x4001,
  kHdForceRamping = 0x4002,
  kHdCalibrationOk = 0x5000,
};
enum : std::uint32_t { kHdCallbackDone = 0, kHdCallbackContinue = 1, kHdWaitCheckStatus = 0 };
enum : std::uint32_t { kHdErrorWarmMotors = 0x0200, kHdErrorForceFirst = 0x0200, kHdErrorForceLast = 0x0204 };
enum : std::uint32_t { kHdCalibrationEncoderReset = 1, kHdCalibrationAuto = 2, kHdCalibrationInkwell = 4 };
inline constexpr std::uint16_t kHdMaxPriority = 65535;

// name, result, arguments; all C functions.
#define SPHERETREE_HD_FUNCTIONS(X)                                           \
  X(hdInitDevice, HdHandle, const char*)                                     \
  X(hdDisableDevice, void, HdHandle)                                         \
  X(hdMakeCurrentDevice, void, HdHandle)                                     \
  X(hdBeginFrame, void, HdHandle)                                            \
  X(hdEndFrame, void, HdHandle)                                              \
  X(hdGetError, HdErrorInfo, void)                                           \
  X(hdGetErrorString, const char*, std::uint32_t)                            \
  X(hdEnable, void, HdEnum)                                                  \
  X(hdGetBooleanv, void, HdEnum, std::uint8_t*)                              \
  X(hdGetIntegerv, void, HdEnum, std::int32_t*)                              \
  X(hdGetDoublev, void, HdEnum, double*)                                     \
  X(hdSetDoublev, void, HdEnum, const double*)                               \
  X(hdGetString, const char*, HdEnum)                                        \
  X(hdCheckCalibration, HdEnum, void)                                        \
  X(hdUpdateCalibration, void, HdEnum)                                       \
  X(hdStartScheduler, void, void)                                            \
  X(hdStopScheduler, void, void)                                             \
  X(hdSetSchedulerRate, void, unsigned long)                                 \
  X(hdScheduleAsynchronous, unsigned long, HdCallback, void*, std::uint16_t) \
  X(hdUnschedule, void, unsigned long)                                       \
  X(hdWaitForCompletion, std::uint8_t, unsigned long, std::uint32_t)         \
  X(hdDeploymentLicense, std::uint8_t, const char*, const char*, const char*)

struct HdApi {
#define SPHERETREE_HD_MEMBER(name, result, ...) result (*name)(__VA_ARGS__);
  SPHERETREE_HD_FUNCTIONS(SPHERETREE_HD_MEMBER)
#undef SPHERETREE_HD_MEMBER
};

/// Loads `library`, or the first of the known names if it is empty. The library stays loaded for the rest of the
/// process, since the driver does not survive a second load. @throws DeviceError
const HdApi& loadHdApi(const std::string& library);

}  // namespace spheretree::device

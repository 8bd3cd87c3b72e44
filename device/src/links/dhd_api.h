// SPDX-License-Identifier: Apache-2.0
// The part of the Force Dimension SDK that we call: declarations of our own, written from its documented interface.
#pragma once

#include <string>

namespace spheretree::device {

inline constexpr int kDhdOn = 1, kDhdOff = 0;
inline constexpr int kDhdMotorSaturated = 2;  // of dhdSetForce...: done, but less than was asked for. Faults are negative

// name, result, arguments; all C functions. The last argument is the number of the device.
#define SPHERETREE_DHD_FUNCTIONS(X)                                                        \
  X(dhdOpenID, int, char)                                                                  \
  X(dhdClose, int, char)                                                                   \
  X(dhdErrorGetLastStr, const char*, void)                                                 \
  X(dhdGetSystemName, const char*, char)                                                   \
  X(dhdHasActiveWrist, bool, char)                                                         \
  X(dhdEnableForce, int, unsigned char, char)                                              \
  X(dhdSetGravityCompensation, int, int, char)                                             \
  X(dhdGetPositionAndOrientationFrame, int, double*, double*, double*, double(*)[3], char) \
  X(dhdGetButtonMask, unsigned, char)                                                      \
  X(dhdSetForceAndTorqueAndGripperForce, int, double, double, double, double, double, double, double, char)

struct DhdApi {
#define SPHERETREE_DHD_MEMBER(name, result, ...) result (*name)(__VA_ARGS__);
  SPHERETREE_DHD_FUNCTIONS(SPHERETREE_DHD_MEMBER)
#undef SPHERETREE_DHD_MEMBER
};

/// Loads `library`, or the first of the known names if it is empty. It stays loaded for the rest of the process.
/// @throws DeviceError
DhdApi loadDhdApi(const std::string& library);

}  // namespace spheretree::device

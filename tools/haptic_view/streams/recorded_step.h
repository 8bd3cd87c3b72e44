// SPDX-License-Identifier: GPL-3.0-or-later
// The data that is kept of a servo step: a row of a recording, a point of the plots. Units: mm, N, N mm, s; times of
// stages in us.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "spheretree/core/rigid.h"

namespace spheretree::player {

inline constexpr std::size_t kMaxHinges = 8;         // hinges that can be steered and recorded; further ones follow the path of the scene
using HingeAngles = std::array<double, kMaxHinges>;  // [degree]

inline constexpr std::uint32_t kUntouched = ~std::uint32_t{0};

struct RecordedStep {
  std::uint64_t tick = 0;
  double time = 0;        // of the tick [s]
  Configuration haptic;   // of the reference point, world frame
  Configuration graphic;  // "
  Wrench wrench;          // on the hand about the reference point, before the device's limits
  std::uint32_t pairs = 0, rows = 0, active = 0, qp_iterations = 0, faults = 0;
  double find_us = 0, rows_us = 0, qp_us = 0, total_us = 0;
  double penetration = 0;              // of the graphic tool's leaves, as reported by the runtime [mm]
  std::uint32_t touched = kUntouched;  // object of the contact with the largest force
  double friction = 0;                 // length of the sum over all contacts [N]
  double slip = 0;                     // tangential speed of the contact with the largest force [mm/s]
  HingeAngles hinges{};                // angles of the bodies with a hinge, in the order of the scene
  std::uint32_t tissue_states = 0;     // number of states of soft tissue used so far
  bool spins = false;                  // whether the burr spins
  double removed = 0;                  // volume that the burr has removed so far, as the runtime estimates it [mm3]
  std::uint32_t layer = kUntouched;    // that the burr touches, among the layers of all objects in the order of the scene
  // Of the step before: the wrench that passivity control added, and the energy that it has yet to remove [N, N mm,
  // mJ].
  double passivity_force = 0, passivity_torque = 0, passivity_debt = 0;
};

}  // namespace spheretree::player

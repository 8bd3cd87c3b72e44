// SPDX-License-Identifier: GPL-3.0-or-later
// The three streams between the servo loop and a view: the latest state and every step one way, where the hand means to
// be the other way.
// Units: mm, N, N mm, s; world axes.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <limits>

#include "streams/recorded_step.h"
#include "streams/step_ring.h"
#include "streams/triple_buffer.h"

namespace spheretree::view {

/// A place where the tool touches something.
struct ShownContact {
  Eigen::Vector3f point{0, 0, 0}, normal{0, 0, 1};  // world; the normal points from the object to the tool
  float force = 0;                                  // along the normal [N]
  Eigen::Vector3f friction{0, 0, 0};                // across it, on the tool [N]
  std::uint32_t object = 0;                         // index in the scene
};
inline constexpr std::size_t kMostContacts = 16;  // more than a step has

/// All that a picture shows of one servo step.
struct LiveState {
  player::RecordedStep step;
  std::uint32_t contact_count = 0;
  std::array<ShownContact, kMostContacts> contacts{};
};

/// Where the hand means to be, as a mouse or another input says.
struct HandTarget {
  Configuration pose;
  bool is_set = false;  // false: nobody has said anything yet
};

/// Rows that wait for the view: 32 s of steps. A window that answers later than that (a driver that hangs) loses rows,
/// and says how many.
inline constexpr std::size_t kStepRing = 1 << 15;

/// A wish for each hinge of the scene, from the view's thread to that of the steps: an angle [degree], or NaN, and the
/// body follows the scene.
struct HingeWishes {
  std::array<std::atomic<double>, player::kMostHinges> degree;
  HingeWishes() {
    for (auto& wish : degree) wish.store(std::numeric_limits<double>::quiet_NaN());
  }
};

struct LiveStreams {
  TripleBuffer<LiveState> state;
  StepRing<player::RecordedStep> steps{kStepRing};
  TripleBuffer<HandTarget> hand;
  HingeWishes hinges;
};

}  // namespace spheretree::view

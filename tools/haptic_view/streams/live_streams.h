// SPDX-License-Identifier: GPL-3.0-or-later
// The three streams between the servo loop and a view: the latest state and every step in one direction, the target of
// the hand in the other.
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

/// A point where the tool touches an object.
struct ShownContact {
  Eigen::Vector3f point{0, 0, 0}, normal{0, 0, 1};  // world frame; the normal points from the object to the tool
  float force = 0;                                  // along the normal [N]
  Eigen::Vector3f friction{0, 0, 0};                // tangential, on the tool [N]
  std::uint32_t object = 0;                         // index in the scene
};
inline constexpr std::size_t kMaxContacts = 16;  // more than a step can have

/// The data of one servo step that a picture shows.
struct LiveState {
  player::RecordedStep step;
  std::uint32_t restarts = 0;  // of the run, before this step
  std::uint32_t contact_count = 0;
  std::array<ShownContact, kMaxContacts> contacts{};
};

/// The target pose of the hand from a mouse or another input.
struct HandTarget {
  Configuration pose;
  bool is_set = false;  // false: no input yet
};

/// Size of the ring buffer of steps for the view: 32 s. A window that reads later than that (because of a driver that
/// hangs) loses rows, and reports how many.
inline constexpr std::size_t kStepRing = 1 << 15;

/// A requested angle for each hinge of the scene, from the view's thread to that of the steps [degree]; NaN: the body
/// follows the scene.
struct HingeWishes {
  std::array<std::atomic<double>, player::kMaxHinges> degree;
  HingeWishes() {
    for (auto& wish : degree) wish.store(std::numeric_limits<double>::quiet_NaN());
  }
};

/// Requested settings of the rendering, from the view's thread to that of the steps; NaN: as the scene says.
struct SettingWishes {
  std::atomic<double> stiffness, damping, friction;  // of the coupling [N/mm, N s/mm]; Coulomb's coefficient, of all objects
  std::atomic<bool> other_mode{false};               // the mode that the run did not begin with
  SettingWishes() {
    for (auto* wish : {&stiffness, &damping, &friction}) wish->store(std::numeric_limits<double>::quiet_NaN());
  }
};

/// Whether the burr is asked to spin, from the view's thread to that of the steps.
enum class SpindleWish : std::uint8_t { None, Off, On };  // None: as its path says, or a button of the device

struct LiveStreams {
  TripleBuffer<LiveState> state;
  StepRing<player::RecordedStep> steps{kStepRing};
  TripleBuffer<HandTarget> hand;
  HingeWishes hinges;
  SettingWishes settings;
  std::atomic<SpindleWish> spindle{SpindleWish::None};
};

}  // namespace spheretree::view

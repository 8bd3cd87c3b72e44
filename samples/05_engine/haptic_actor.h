// SPDX-License-Identifier: Apache-2.0
// An actor of an engine in C++ whose tool a hand holds by a haptic device: the engine calls start() once, tick() for
// each picture, and moves what moves by move().
#pragma once

#include <stdexcept>
#include <string>

#include "spheretree/servo/servo.h"

class HapticActor {
 public:
  HapticActor() { state_.struct_size = sizeof state_; }
  ~HapticActor() { st_servo_stop(servo_); }
  HapticActor(const HapticActor&) = delete;
  HapticActor& operator=(const HapticActor&) = delete;

  /// @throws std::runtime_error with a sentence that says what to do
  void start(st_scene* scene, const char* device, const st_servo_options& options) {
    servo_ = st_servo_start(scene, device, &options);
    if (!servo_) throw std::runtime_error(st_servo_error());
  }
  /// Once for each picture: draw the tool at state().graphic_tool.
  void tick() { st_servo_state(servo_, &state_); }
  const st_servo_snapshot& state() const { return state_; }

  /// Body `body` is at `pose` in the picture that is drawn now.
  bool move(unsigned body, const st_pose& pose) { return st_servo_move_body(servo_, body, &pose) == 0; }
  /// Where the hand of the simulated device means to be; other devices have a hand of their own.
  bool moveHand(const st_pose& tool) { return st_servo_move_hand(servo_, &tool) == 0; }

 private:
  st_servo* servo_ = nullptr;
  st_servo_snapshot state_{};
};

// SPDX-License-Identifier: GPL-3.0-or-later
// The motors of a gamepad, by Linux force feedback: they say how fast the force on the hand changes. A rumble cannot
// show the force itself. Units: N, s.
#pragma once

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>

namespace spheretree::view {

/// Strength of both motors, 0 to 1: the left one is slow and strong, the right one fast and weak.
struct RumbleStrength {
  double strong = 0, weak = 0;
};

/// How strongly the force changes, from the force of each servo step.
class RumbleSignal {
 public:
  static constexpr double kFull = 1;      // a change by this, faster than kTime, is full strength [N]
  static constexpr double kTime = 0.02;   // a change within this time is felt as one event [s]
  static constexpr double kDecay = 0.08;  // afterwards the strength falls to 1 / e in this time [s]
  void add(const Eigen::Vector3d& force, double step_seconds);
  RumbleStrength strength() const;
  void clear() { *this = {}; }

 private:
  Eigen::Vector3d slow_ = Eigen::Vector3d::Zero();
  double strength_ = 0;
};

/// The calls of the system that Rumble makes; tests replace them.
struct EventCalls {
  int (*open)(const char* path, int flags);
  int (*ioctl)(int file, unsigned long request, void* argument);
  long (*write)(int file, const void* bytes, std::size_t count);
  int (*close)(int file);
};
const EventCalls& systemEventCalls();

class Rumble {
 public:
  /// The gamepad of this vendor and product whose event device in `folder` has motors. Check isOpen() afterwards.
  Rumble(std::uint16_t vendor, std::uint16_t product, const EventCalls& calls = systemEventCalls(),
         const std::filesystem::path& folder = "/dev/input");
  ~Rumble();
  Rumble(const Rumble&) = delete;
  Rumble& operator=(const Rumble&) = delete;

  bool isOpen() const { return file_ >= 0; }
  /// Why it is not open, and what to do.
  const std::string& fault() const { return fault_; }
  /// Call it about 30 times a second. If the calls end, the motors stop after kHold. After an error of the device (it
  /// was unplugged) it is closed.
  void set(const RumbleStrength& strength);

  static constexpr int kHold = 200;  // [ms]

 private:
  void end();
  const EventCalls& calls_;
  int file_ = -1;
  std::int16_t effect_ = -1;
  bool is_moving_ = false;
  std::string fault_;
};

/// Vendor and product in the identity that GLFW reports of a joystick (32 hexadecimal digits, as SDL has them). Returns
/// false for another text.
bool idsOfGamepad(const std::string& guid, std::uint16_t& vendor, std::uint16_t& product);

}  // namespace spheretree::view

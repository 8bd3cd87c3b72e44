// SPDX-License-Identifier: GPL-3.0-or-later
#include "hand/rumble.h"

#include <fcntl.h>
#include <linux/input.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <vector>

namespace spheretree::view {
namespace {

std::uint16_t motor(double share) { return static_cast<std::uint16_t>(std::lround(65535 * std::clamp(share, 0.0, 1.0))); }

}  // namespace

void RumbleSignal::add(const Eigen::Vector3d& force, double step_seconds) {
  slow_ += std::min(1.0, step_seconds / kTime) * (force - slow_);
  strength_ = std::max(strength_ * std::exp(-step_seconds / kDecay), std::min(1.0, (force - slow_).norm() / kFull));
}

RumbleStrength RumbleSignal::strength() const {
  constexpr double kStill = 0.03;  // below this nothing moves: the noise of a resting hand
  if (strength_ < kStill) return {};
  return {strength_ * strength_, std::sqrt(strength_)};  // small events by the fast motor alone
}

const EventCalls& systemEventCalls() {
  static const EventCalls calls{[](const char* path, int flags) { return ::open(path, flags); },
                                [](int file, unsigned long request, void* argument) { return ::ioctl(file, request, argument); },
                                [](int file, const void* bytes, std::size_t count) -> long { return ::write(file, bytes, count); },
                                [](int file) { return ::close(file); }};
  return calls;
}

Rumble::Rumble(std::uint16_t vendor, std::uint16_t product, const EventCalls& calls, const std::filesystem::path& folder) : calls_(calls) {
  std::vector<std::filesystem::path> devices;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    if (entry->path().filename().string().starts_with("event")) devices.push_back(entry->path());
  std::sort(devices.begin(), devices.end());
  for (const std::filesystem::path& device : devices) {
    // Motors need the right to write; who may only read can still see which device it is.
    bool is_writable = true;
    file_ = calls_.open(device.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
    const int why = errno;
    if (file_ < 0 && (why == EACCES || why == EPERM)) {
      is_writable = false;
      file_ = calls_.open(device.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
    }
    if (file_ < 0) continue;
    input_id id{};
    std::array<unsigned long, FF_MAX / (8 * sizeof(unsigned long)) + 1> can{};
    const bool is_pad = calls_.ioctl(file_, EVIOCGID, &id) >= 0 && id.vendor == vendor && id.product == product &&
                        calls_.ioctl(file_, EVIOCGBIT(EV_FF, sizeof can), can.data()) >= 0;
    constexpr std::size_t kBits = 8 * sizeof(unsigned long);
    if (is_pad && (can[FF_RUMBLE / kBits] >> (FF_RUMBLE % kBits) & 1)) {
      if (is_writable) return;
      fault_ =
          "no rumble: " + device.string() + ": " + std::strerror(why) + ". Add yourself to the group of the file (input), and log in again";
    }
    end();
    if (!fault_.empty()) return;
  }
  fault_ = "no rumble: the gamepad has no motors that Linux knows";
}

Rumble::~Rumble() { end(); }

void Rumble::end() {
  if (file_ >= 0) calls_.close(file_);  // which also ends its effects
  file_ = -1;
}

void Rumble::set(const RumbleStrength& strength) {
  if (file_ < 0) return;
  const bool moves = strength.strong > 0 || strength.weak > 0;
  if (!moves && !is_moving_) return;
  is_moving_ = moves;
  ff_effect effect{};
  effect.type = FF_RUMBLE;
  effect.id = effect_;
  effect.replay.length = kHold;
  effect.u.rumble.strong_magnitude = motor(strength.strong);
  effect.u.rumble.weak_magnitude = motor(strength.weak);
  input_event play{};
  play.type = EV_FF;
  const bool is_set = calls_.ioctl(file_, EVIOCSFF, &effect) >= 0;
  effect_ = effect.id;
  play.code = static_cast<std::uint16_t>(effect.id);
  play.value = moves ? 1 : 0;
  if (is_set && calls_.write(file_, &play, sizeof play) == static_cast<long>(sizeof play)) return;
  fault_ = std::string("the rumble ended: ") + std::strerror(errno);
  end();
}

bool idsOfGamepad(const std::string& guid, std::uint16_t& vendor, std::uint16_t& product) {
  // Little-endian words: bus, 0, vendor, 0, product, 0, version, 0.
  const auto word = [&](std::size_t at) { return std::stoul(guid.substr(at + 2, 2) + guid.substr(at, 2), nullptr, 16); };
  if (guid.size() != 32 || guid.find_first_not_of("0123456789abcdefABCDEF") != std::string::npos) return false;
  vendor = static_cast<std::uint16_t>(word(8));
  product = static_cast<std::uint16_t>(word(16));
  return vendor != 0;
}

}  // namespace spheretree::view

// SPDX-License-Identifier: Apache-2.0
// The message of spheretree.device/1: 96 bytes, little-endian, the same layout in both directions. Units: mm, N, N mm.
// The table of the bytes is in docs/device.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "spheretree/core/rigid.h"

namespace spheretree::device {

inline constexpr std::size_t kNetBytes = 96;

struct NetPacket {
  enum Kind : std::uint16_t { kState = 1, kWrench = 2 };                  // from the device; to the device
  enum Flag : std::uint16_t { kReleased = 1, kFailed = 2, kTorque = 4 };  // of a state; kTorque: the device renders torques
  std::uint16_t kind = kState, flags = 0;
  std::uint32_t buttons = 0;
  float temperature = 0;
  std::uint64_t sequence = 0;  // increases by 1 with each message of a sender
  std::uint64_t time_ns = 0;   // of the sender's clock
  std::uint64_t echo = 0;      // sequence number of the last message that the sender received
  Configuration pose;          // of the handle; in a wrench: the pose that it responds to
  Wrench wrench;               // on the hand; in a state: the wrench that was rendered last
};

/// Numbers are rounded to float.
std::array<std::byte, kNetBytes> encoded(const NetPacket& packet) noexcept;
/// Nothing if size, mark, kind or checksum is wrong. Numbers may be anything.
std::optional<NetPacket> decoded(std::span<const std::byte> bytes) noexcept;

}  // namespace spheretree::device

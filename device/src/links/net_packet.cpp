// SPDX-License-Identifier: Apache-2.0
#include "links/net_packet.h"

#include <bit>
#include <cstring>

namespace spheretree::device {
namespace {

static_assert(std::endian::native == std::endian::little);

constexpr char kMark[4] = {'S', 'T', 'D', '1'};
constexpr std::size_t kSummed = kNetBytes - sizeof(std::uint32_t);

std::uint32_t checksum(const std::byte* bytes) noexcept {  // FNV-1a
  std::uint32_t sum = 2166136261u;
  for (std::size_t n = 0; n < kSummed; ++n) sum = (sum ^ std::to_integer<std::uint32_t>(bytes[n])) * 16777619u;
  return sum;
}

/// Calls `field` for each number of the message, in their order.
template <class Packet, class Field>
void eachField(Packet& p, const Field& field) {
  field(p.kind), field(p.flags), field(p.buttons), field(p.temperature), field(p.sequence), field(p.time_ns), field(p.echo);
  for (int k = 0; k < 3; ++k) field(p.pose.position[k]);
  field(p.pose.orientation.w()), field(p.pose.orientation.x()), field(p.pose.orientation.y()), field(p.pose.orientation.z());
  for (int k = 0; k < 3; ++k) field(p.wrench.force[k]);
  for (int k = 0; k < 3; ++k) field(p.wrench.torque[k]);
}

}  // namespace

std::array<std::byte, kNetBytes> encoded(const NetPacket& packet) noexcept {
  std::array<std::byte, kNetBytes> bytes{};
  std::byte* at = bytes.data();
  const auto put = [&at](const auto& value) {
    std::memcpy(at, &value, sizeof value);
    at += sizeof value;
  };
  put(kMark);
  eachField(packet, [&](const auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>)
      put(static_cast<float>(value));
    else
      put(value);
  });
  put(checksum(bytes.data()));
  return bytes;
}

std::optional<NetPacket> decoded(std::span<const std::byte> bytes) noexcept {
  std::uint32_t sum = 0;
  if (bytes.size() != kNetBytes || std::memcmp(bytes.data(), kMark, sizeof kMark) != 0) return std::nullopt;
  std::memcpy(&sum, bytes.data() + kSummed, sizeof sum);
  if (sum != checksum(bytes.data())) return std::nullopt;
  NetPacket packet;
  const std::byte* at = bytes.data() + sizeof kMark;
  const auto take = [&at](auto& value) {
    std::memcpy(&value, at, sizeof value);
    at += sizeof value;
  };
  eachField(packet, [&](auto& value) {
    if constexpr (std::is_same_v<std::decay_t<decltype(value)>, double>) {
      float rounded = 0;
      take(rounded);
      value = static_cast<double>(rounded);
    } else {
      take(value);
    }
  });
  if (packet.kind != NetPacket::kState && packet.kind != NetPacket::kWrench) return std::nullopt;
  return packet;
}

}  // namespace spheretree::device

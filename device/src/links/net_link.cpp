// SPDX-License-Identifier: Apache-2.0
#include "links/net_link.h"

#include <thread>
#include <utility>

#include "spheretree/device/device_server.h"

namespace spheretree::device {
namespace {

constexpr std::chrono::milliseconds kForgotten{200};  // after this silence a sender may begin again with sequence number 0

}  // namespace

NetSocket::NetSocket(const SocketAddress& address, bool is_server) {
  if (!is_server) return;
  if (const int error = socket_.bind(address); error != 0)
    throw DeviceError(DeviceFault::Refused, "spheretree.device/1: port " + std::to_string(address.port) + " cannot be served: " +
                                                socketWords(error) + ". End the other program, or choose another port");
}

std::optional<NetPacket> NetSocket::receive(NetPacket::Kind kind, SocketAddress& from) noexcept {
  std::array<char, kNetBytes + 1> bytes;  // one more: a longer message is not taken for a whole one
  for (int n = 0; n < kMostMessages; ++n) {
    const Transfer got = socket_.receiveFrom(bytes, from);
    if (got.error != 0) return std::nullopt;
    const std::optional<NetPacket> packet = decoded(std::as_bytes(std::span(bytes)).first(got.bytes));
    if (packet && packet->kind == kind) return packet;
  }
  return std::nullopt;
}

void NetSocket::send(const NetPacket& packet, const SocketAddress& to) noexcept {
  NetPacket now = packet;
  now.time_ns = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count());
  const std::array<std::byte, kNetBytes> bytes = encoded(now);
  socket_.sendTo({reinterpret_cast<const char*>(bytes.data()), bytes.size()}, to);
}

std::uint16_t NetSocket::port() const noexcept { return socket_.ownAddress().port; }

NetLink::NetLink(const SocketAddress& server, const std::string& name) : server_(server), socket_(server, false) {
  constexpr int kTries = 200;
  LinkState first;
  bool answered = false;
  for (int n = 0; n < kTries && !answered; ++n) {  // its state is an answer to our wrench
    send({});
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
    answered = read(first);
  }
  if (!answered)
    throw DeviceError(DeviceFault::NotFound,
                      name + " does not answer: start the program that serves the device there (haptic-player: --serve)");
  has_first_ = true;
  info_.model = name;
  info_.driver = "spheretree.device/1";
  info_.renders_torque = (last_.flags & NetPacket::kTorque) != 0;
  info_.can_step = false;
  info_.delay = 1;
}

bool NetLink::read(LinkState& state) noexcept {
  bool is_new = std::exchange(has_first_, false);
  SocketAddress from{};
  for (int n = 0; n < kMostMessages; ++n) {
    const std::optional<NetPacket> packet = socket_.receive(NetPacket::kState, from);
    if (!packet) break;
    if (from != server_) continue;
    const auto now = std::chrono::steady_clock::now();
    if (packet->sequence <= last_.sequence && now - heard_ < kForgotten) continue;  // late, or twice
    heard_ = now;
    last_ = *packet;
    is_new = true;
  }
  if (!is_new) return false;
  state.handle = last_.pose;
  state.buttons = last_.buttons;
  state.released = (last_.flags & NetPacket::kReleased) != 0;
  state.failed = (last_.flags & NetPacket::kFailed) != 0;
  state.temperature = last_.temperature;
  return true;
}

void NetLink::send(const Wrench& wrench) noexcept {
  NetPacket packet;
  packet.kind = NetPacket::kWrench;
  packet.sequence = ++sequence_;
  packet.echo = last_.sequence;
  packet.pose = last_.pose;
  packet.wrench = wrench;
  socket_.send(packet, server_);
}

DeviceServer::DeviceServer(std::uint16_t port, bool allow_remote, const DeviceInfo& info) : renders_torque_(info.renders_torque) {
  const SocketAddress address{allow_remote ? kAnyHost : kThisHost, port};
  socket_ = std::make_unique<NetSocket>(address, true);
}

DeviceServer::~DeviceServer() = default;

std::uint16_t DeviceServer::port() const noexcept { return socket_->port(); }

Rendered DeviceServer::render(const DeviceState& state) noexcept {
  const double forgotten = std::chrono::duration<double>(kForgotten).count();
  SocketAddress from{};
  for (int n = 0; n < kMostMessages; ++n) {
    const std::optional<NetPacket> packet = socket_->receive(NetPacket::kWrench, from);
    if (!packet) break;
    const bool is_free = !was_heard_ || state.time - heard_ > forgotten;  // nobody holds the device
    if (!is_free && (from != socket_->peer || packet->sequence <= last_)) continue;
    socket_->peer = from;
    last_ = packet->sequence;
    wrench_ = packet->wrench;
    heard_ = state.time;
    was_heard_ = true;
  }
  const double age = was_heard_ ? state.time - heard_ : 0;
  has_client_.store(was_heard_ && age <= forgotten, std::memory_order_relaxed);
  if (was_heard_ && age <= forgotten) {
    NetPacket packet;
    packet.flags = static_cast<std::uint16_t>((state.released ? NetPacket::kReleased : 0) | (state.failed ? NetPacket::kFailed : 0) |
                                              (renders_torque_ ? NetPacket::kTorque : 0));
    packet.buttons = state.buttons;
    packet.temperature = static_cast<float>(state.temperature);
    packet.sequence = ++sequence_;
    packet.echo = last_;
    packet.pose = state.handle;
    packet.wrench = wrench_;
    socket_->send(packet, socket_->peer);
  }
  return {wrench_, age, false};
}

}  // namespace spheretree::device

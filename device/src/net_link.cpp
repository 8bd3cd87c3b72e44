// SPDX-License-Identifier: Apache-2.0
#include "net_link.h"

#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <thread>
#include <utility>

#include "spheretree/device/device_server.h"

namespace spheretree::device {
namespace {

constexpr std::chrono::milliseconds kForgotten{200};  // after this silence a sender may begin again with sequence number 0

bool isSame(const sockaddr_in& a, const sockaddr_in& b) noexcept {
  return a.sin_addr.s_addr == b.sin_addr.s_addr && a.sin_port == b.sin_port;
}

}  // namespace

NetSocket::NetSocket(const sockaddr_in& address, bool is_server)
    : socket_(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  if (socket_ < 0) throw DeviceError(DeviceFault::Refused, std::string("spheretree.device/1: no socket: ") + std::strerror(errno));
  if (!is_server || ::bind(socket_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return;
  const std::string why = std::strerror(errno);
  ::close(socket_);
  throw DeviceError(DeviceFault::Refused, "spheretree.device/1: port " + std::to_string(ntohs(address.sin_port)) +
                                              " cannot be served: " + why + ". End the other program, or choose another port");
}

NetSocket::~NetSocket() { ::close(socket_); }

std::optional<NetPacket> NetSocket::receive(NetPacket::Kind kind, sockaddr_in& from) noexcept {
  std::array<std::byte, kNetBytes + 1> bytes;  // one more: a longer message is not taken for a whole one
  for (int n = 0; n < kMostMessages; ++n) {
    socklen_t size = sizeof from;
    const ssize_t got = ::recvfrom(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&from), &size);
    if (got < 0) return std::nullopt;
    const std::optional<NetPacket> packet = decoded(std::span(bytes).first(static_cast<std::size_t>(got)));
    if (packet && packet->kind == kind) return packet;
  }
  return std::nullopt;
}

void NetSocket::send(const NetPacket& packet, const sockaddr_in& to) noexcept {
  NetPacket now = packet;
  now.time_ns = static_cast<std::uint64_t>(
      std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch()).count());
  const std::array<std::byte, kNetBytes> bytes = encoded(now);
  ::sendto(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL, reinterpret_cast<const sockaddr*>(&to), sizeof to);
}

std::uint16_t NetSocket::port() const noexcept {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  ::getsockname(socket_, reinterpret_cast<sockaddr*>(&address), &size);
  return ntohs(address.sin_port);
}

NetLink::NetLink(const sockaddr_in& server, const std::string& name) : server_(server), socket_(server, false) {
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
  sockaddr_in from{};
  for (int n = 0; n < kMostMessages; ++n) {
    const std::optional<NetPacket> packet = socket_.receive(NetPacket::kState, from);
    if (!packet) break;
    if (!isSame(from, server_)) continue;
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
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(allow_remote ? INADDR_ANY : INADDR_LOOPBACK);
  socket_ = std::make_unique<NetSocket>(address, true);
}

DeviceServer::~DeviceServer() = default;

std::uint16_t DeviceServer::port() const noexcept { return socket_->port(); }

Rendered DeviceServer::render(const DeviceState& state) noexcept {
  const double forgotten = std::chrono::duration<double>(kForgotten).count();
  sockaddr_in from{};
  for (int n = 0; n < kMostMessages; ++n) {
    const std::optional<NetPacket> packet = socket_->receive(NetPacket::kWrench, from);
    if (!packet) break;
    const bool is_free = !was_heard_ || state.time - heard_ > forgotten;  // nobody holds the device
    if (!is_free && (!isSame(from, socket_->peer) || packet->sequence <= last_)) continue;
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

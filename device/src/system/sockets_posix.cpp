// SPDX-License-Identifier: Apache-2.0
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <system_error>

#include "spheretree/device/device.h"
#include "system/sockets.h"

namespace spheretree::device {
namespace {

sockaddr_in systemAddress(const SocketAddress& address) noexcept {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_addr.s_addr = htonl(address.host);
  out.sin_port = htons(address.port);
  return out;
}

SocketAddress addressIn(const sockaddr_in& address) noexcept { return {ntohl(address.sin_addr.s_addr), ntohs(address.sin_port)}; }

Transfer transferred(ssize_t count) noexcept {
  if (count >= 0) return {static_cast<std::size_t>(count), 0};
  return {0, errno == EAGAIN || errno == EINTR ? kWouldWait : errno};
}

bool isReady(std::intptr_t socket, short event, std::chrono::milliseconds patience) noexcept {
  pollfd ready{static_cast<int>(socket), event, 0};
  return ::poll(&ready, 1, static_cast<int>(patience.count())) == 1;
}

}  // namespace

std::optional<std::uint32_t> findHost(const std::string& host, std::string& why) {
  addrinfo hints{};
  hints.ai_family = AF_INET;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), nullptr, &hints, &found); error != 0) {
    why = ::gai_strerror(error);
    return std::nullopt;
  }
  sockaddr_in address;
  std::memcpy(&address, found->ai_addr, sizeof address);
  ::freeaddrinfo(found);
  return addressIn(address).host;
}

std::string socketWords(int error) { return std::system_category().message(error); }

Socket::Socket(Kind kind)
    : socket_(::socket(AF_INET, (kind == Kind::Datagrams ? SOCK_DGRAM : SOCK_STREAM) | SOCK_NONBLOCK | SOCK_CLOEXEC, 0)) {
  if (socket_ < 0) throw DeviceError(DeviceFault::Refused, "no socket: " + socketWords(errno));
}

Socket::~Socket() { ::close(static_cast<int>(socket_)); }

int Socket::bind(const SocketAddress& address) noexcept {
  const sockaddr_in at = systemAddress(address);
  return ::bind(static_cast<int>(socket_), reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0 ? 0 : errno;
}

int Socket::connect(const SocketAddress& address, std::chrono::milliseconds patience) noexcept {
  const sockaddr_in to = systemAddress(address);
  if (::connect(static_cast<int>(socket_), reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) return 0;
  if (errno != EINPROGRESS) return errno;
  if (!isReady(socket_, POLLOUT, patience)) return ETIMEDOUT;
  int error = 0;
  socklen_t size = sizeof error;
  return ::getsockopt(static_cast<int>(socket_), SOL_SOCKET, SO_ERROR, &error, &size) == 0 ? error : errno;
}

int Socket::holdBackAtMost(int bytes) noexcept {
  const int on = 1, socket = static_cast<int>(socket_);
  const bool ok = ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, &on, sizeof on) == 0 &&
                  ::setsockopt(socket, SOL_SOCKET, SO_SNDBUF, &bytes, sizeof bytes) == 0;
  return ok ? 0 : errno;
}

SocketAddress Socket::ownAddress() const noexcept {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  ::getsockname(static_cast<int>(socket_), reinterpret_cast<sockaddr*>(&address), &size);
  return addressIn(address);
}

bool Socket::waitForData(std::chrono::milliseconds patience) noexcept { return isReady(socket_, POLLIN, patience); }

Transfer Socket::receive(std::span<char> space) noexcept {
  return transferred(::recv(static_cast<int>(socket_), space.data(), space.size(), MSG_DONTWAIT));
}

Transfer Socket::receiveFrom(std::span<char> space, SocketAddress& from) noexcept {
  sockaddr_in sender{};
  socklen_t size = sizeof sender;
  const Transfer got = transferred(
      ::recvfrom(static_cast<int>(socket_), space.data(), space.size(), MSG_DONTWAIT, reinterpret_cast<sockaddr*>(&sender), &size));
  from = addressIn(sender);
  return got;
}

Transfer Socket::send(std::span<const char> bytes) noexcept {
  return transferred(::send(static_cast<int>(socket_), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL));
}

Transfer Socket::sendTo(std::span<const char> bytes, const SocketAddress& to) noexcept {
  const sockaddr_in receiver = systemAddress(to);
  return transferred(::sendto(static_cast<int>(socket_), bytes.data(), bytes.size(), MSG_DONTWAIT | MSG_NOSIGNAL,
                              reinterpret_cast<const sockaddr*>(&receiver), sizeof receiver));
}

}  // namespace spheretree::device

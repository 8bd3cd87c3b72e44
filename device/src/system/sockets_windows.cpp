// SPDX-License-Identifier: Apache-2.0
#include <winsock2.h>
#include <ws2tcpip.h>
// After winsock2.h:
#include <mswsock.h>

#include <cstring>
#include <system_error>

#include "spheretree/device/device.h"
#include "system/sockets.h"

namespace spheretree::device {
namespace {

/// Sockets work from the first use on, until the process ends.
void startSockets() {
  static const int error = [] {
    WSADATA about;
    return ::WSAStartup(MAKEWORD(2, 2), &about);
  }();
  if (error != 0) throw DeviceError(DeviceFault::Refused, "no sockets: " + socketWords(error));
}

sockaddr_in systemAddress(const SocketAddress& address) noexcept {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_addr.s_addr = ::htonl(address.host);
  out.sin_port = ::htons(address.port);
  return out;
}

SocketAddress addressIn(const sockaddr_in& address) noexcept { return {::ntohl(address.sin_addr.s_addr), ::ntohs(address.sin_port)}; }

SOCKET systemSocket(std::intptr_t socket) noexcept { return static_cast<SOCKET>(socket); }

int errorUnless(bool ok) noexcept { return ok ? 0 : ::WSAGetLastError(); }

/// A message that is longer than its space, of `size` bytes, is an error here: its beginning was received.
Transfer transferred(int count, std::size_t size) noexcept {
  if (count >= 0) return {static_cast<std::size_t>(count), 0};
  const int error = ::WSAGetLastError();
  if (error == WSAEMSGSIZE) return {size, 0};
  return {0, error == WSAEWOULDBLOCK || error == WSAEINTR ? kWouldWait : error};
}

/// Waits until the socket can be written (or its connection failed), or else read.
bool isReady(std::intptr_t socket, bool to_write, std::chrono::milliseconds patience) noexcept {
  fd_set sockets, failed;
  FD_ZERO(&sockets);
  FD_SET(systemSocket(socket), &sockets);
  failed = sockets;
  timeval limit{static_cast<long>(patience.count() / 1000), static_cast<long>(patience.count() % 1000 * 1000)};
  return ::select(0, to_write ? nullptr : &sockets, to_write ? &sockets : nullptr, &failed, &limit) > 0;
}

}  // namespace

std::optional<std::uint32_t> findHost(const std::string& host, std::string& why) {
  startSockets();
  addrinfo hints{};
  hints.ai_family = AF_INET;
  addrinfo* found = nullptr;
  if (const int error = ::getaddrinfo(host.c_str(), nullptr, &hints, &found); error != 0) {
    why = socketWords(error);
    return std::nullopt;
  }
  sockaddr_in address;
  std::memcpy(&address, found->ai_addr, sizeof address);
  ::freeaddrinfo(found);
  return addressIn(address).host;
}

std::string socketWords(int error) { return std::system_category().message(error); }

Socket::Socket(Kind kind) {
  startSockets();
  const SOCKET made = ::socket(AF_INET, kind == Kind::Datagrams ? SOCK_DGRAM : SOCK_STREAM, 0);
  if (made == INVALID_SOCKET) throw DeviceError(DeviceFault::Refused, "no socket: " + socketWords(::WSAGetLastError()));
  socket_ = static_cast<std::intptr_t>(made);
  u_long on = 1;
  ::ioctlsocket(made, FIONBIO, &on);  // nothing waits
  if (kind != Kind::Datagrams) return;
  // Or the news that nobody listens at the other side would take the place of messages.
  BOOL is_told = FALSE;
  DWORD none = 0;
  ::WSAIoctl(made, SIO_UDP_CONNRESET, &is_told, sizeof is_told, nullptr, 0, &none, nullptr, nullptr);
}

Socket::~Socket() { ::closesocket(systemSocket(socket_)); }

int Socket::bind(const SocketAddress& address) noexcept {
  const BOOL alone = TRUE;  // or another program could take the port over
  ::setsockopt(systemSocket(socket_), SOL_SOCKET, SO_EXCLUSIVEADDRUSE, reinterpret_cast<const char*>(&alone), sizeof alone);
  const sockaddr_in at = systemAddress(address);
  return errorUnless(::bind(systemSocket(socket_), reinterpret_cast<const sockaddr*>(&at), sizeof at) == 0);
}

int Socket::connect(const SocketAddress& address, std::chrono::milliseconds patience) noexcept {
  const sockaddr_in to = systemAddress(address);
  if (::connect(systemSocket(socket_), reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0) return 0;
  if (const int error = ::WSAGetLastError(); error != WSAEWOULDBLOCK) return error;
  if (!isReady(socket_, true, patience)) return WSAETIMEDOUT;
  int error = 0, size = sizeof error;
  const bool ok = ::getsockopt(systemSocket(socket_), SOL_SOCKET, SO_ERROR, reinterpret_cast<char*>(&error), &size) == 0;
  return ok ? error : ::WSAGetLastError();
}

int Socket::holdBackAtMost(int bytes) noexcept {
  const BOOL on = TRUE;
  return errorUnless(::setsockopt(systemSocket(socket_), IPPROTO_TCP, TCP_NODELAY, reinterpret_cast<const char*>(&on), sizeof on) == 0 &&
                     ::setsockopt(systemSocket(socket_), SOL_SOCKET, SO_SNDBUF, reinterpret_cast<const char*>(&bytes), sizeof bytes) == 0);
}

SocketAddress Socket::ownAddress() const noexcept {
  sockaddr_in address{};
  int size = sizeof address;
  ::getsockname(systemSocket(socket_), reinterpret_cast<sockaddr*>(&address), &size);
  return addressIn(address);
}

bool Socket::waitForData(std::chrono::milliseconds patience) noexcept { return isReady(socket_, false, patience); }

Transfer Socket::receive(std::span<char> space) noexcept {
  return transferred(::recv(systemSocket(socket_), space.data(), static_cast<int>(space.size()), 0), space.size());
}

Transfer Socket::receiveFrom(std::span<char> space, SocketAddress& from) noexcept {
  sockaddr_in sender{};
  int size = sizeof sender;
  const int count =
      ::recvfrom(systemSocket(socket_), space.data(), static_cast<int>(space.size()), 0, reinterpret_cast<sockaddr*>(&sender), &size);
  const Transfer got = transferred(count, space.size());
  from = addressIn(sender);
  return got;
}

Transfer Socket::send(std::span<const char> bytes) noexcept {
  return transferred(::send(systemSocket(socket_), bytes.data(), static_cast<int>(bytes.size()), 0), 0);
}

Transfer Socket::sendTo(std::span<const char> bytes, const SocketAddress& to) noexcept {
  const sockaddr_in receiver = systemAddress(to);
  return transferred(::sendto(systemSocket(socket_), bytes.data(), static_cast<int>(bytes.size()), 0,
                              reinterpret_cast<const sockaddr*>(&receiver), sizeof receiver),
                     0);
}

}  // namespace spheretree::device

// SPDX-License-Identifier: Apache-2.0
// Sockets of IPv4: sockets_posix.cpp and sockets_windows.cpp. Only connect() and waitForData() wait.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

namespace spheretree::device {

struct SocketAddress {  // in the byte order of this machine
  std::uint32_t host = 0;
  std::uint16_t port = 0;
  friend bool operator==(const SocketAddress&, const SocketAddress&) = default;
};
inline constexpr std::uint32_t kAnyHost = 0, kThisHost = 0x7f000001;  // 127.0.0.1

/// The first address of a host, given by its name or number. None with the system's words in `why`.
std::optional<std::uint32_t> findHost(const std::string& host, std::string& why);

/// The system's words for an error of a socket.
std::string socketWords(int error);

/// How many bytes went; or why none did: `error` is kWouldWait or a number of the system. A connection that received no
/// bytes without an error has been closed by the other side.
struct Transfer {
  std::size_t bytes = 0;
  int error = 0;
};
inline constexpr int kWouldWait = -1;

class Socket {
 public:
  enum class Kind { Datagrams, Stream };
  explicit Socket(Kind kind);  // @throws DeviceError Refused
  ~Socket();
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;

  // All return 0 or the number of an error.
  int bind(const SocketAddress& address) noexcept;
  int connect(const SocketAddress& address, std::chrono::milliseconds patience) noexcept;
  /// Sends each part of a stream at once, and holds back at most `bytes` that the other side does not take.
  int holdBackAtMost(int bytes) noexcept;

  SocketAddress ownAddress() const noexcept;
  bool waitForData(std::chrono::milliseconds patience) noexcept;  // false: none came

  Transfer receive(std::span<char> space) noexcept;
  Transfer receiveFrom(std::span<char> space, SocketAddress& from) noexcept;  // what is longer than `space` is cut off
  Transfer send(std::span<const char> bytes) noexcept;
  Transfer sendTo(std::span<const char> bytes, const SocketAddress& to) noexcept;

 private:
  std::intptr_t socket_;  // a descriptor, or a handle of Windows
};

}  // namespace spheretree::device

// SPDX-License-Identifier: Apache-2.0
// A stand-in for the vendor's service: a WebSocket server on this machine that replies to each command, and misbehaves
// as a test asks.
#pragma once

#ifdef _WIN32
#include <winsock2.h>
#else
#include <arpa/inet.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>
#endif

#include <array>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <string>
#include <thread>

#include "links/json_scan.h"

namespace spheretree::device::test {

#ifdef _WIN32
using ServerSocket = SOCKET;
inline int pollOne(WSAPOLLFD& one, int ms) { return ::WSAPoll(&one, 1, ms); }
inline void closeSocket(ServerSocket socket) { ::closesocket(socket); }
using Poll = WSAPOLLFD;
using AddressSize = int;
using ByteCount = int;
constexpr int kNoSignal = 0;
#else
using ServerSocket = int;
inline int pollOne(pollfd& one, int ms) { return ::poll(&one, 1, ms); }
inline void closeSocket(ServerSocket socket) { ::close(socket); }
using Poll = pollfd;
using AddressSize = socklen_t;
using ByteCount = std::size_t;
constexpr int kNoSignal = MSG_NOSIGNAL;
#endif

class FakeHaply {
 public:
  enum Mode { kGood, kDrop, kSplit, kFragments, kHuge, kNan, kWrongDevice, kGarbage, kNoGrip, kPing, kClose, kMasked, kNotWebSocket };
  std::atomic<Mode> mode{kGood};
  std::atomic<double> x{0}, y{0}, z{0};  // of the cursor [m]
  std::atomic<unsigned> buttons{0};
  std::atomic<double> force_x{0}, force_y{0}, force_z{0}, largest{0};  // of the last command; of all [N]
  std::atomic<long> commands{0}, unmasked{0}, pongs{0};

  FakeHaply() {
#ifdef _WIN32
    WSADATA about;
    if (::WSAStartup(MAKEWORD(2, 2), &about) != 0) std::abort();
#endif
    listening_ = ::socket(AF_INET, SOCK_STREAM, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    AddressSize size = sizeof address;
    if (::bind(listening_, reinterpret_cast<sockaddr*>(&address), size) != 0 || ::listen(listening_, 4) != 0) std::abort();
    ::getsockname(listening_, reinterpret_cast<sockaddr*>(&address), &size);
    port_ = ntohs(address.sin_port);
    thread_ = std::thread([this] { run(); });
  }
  ~FakeHaply() {
    stop_ = true;
    thread_.join();
    closeSocket(listening_);
  }
  std::string host() const { return "127.0.0.1:" + std::to_string(port_); }
  /// Waits until `count` commands have come, at most 5 s.
  bool heard(long count) const {
    for (int n = 0; n < 5000 && commands < count; ++n) std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return commands >= count;
  }

 private:
  bool waits(ServerSocket socket) const {
    Poll ready{socket, POLLIN, 0};
    return pollOne(ready, 10) == 1;
  }
  bool read(ServerSocket socket, char* to, std::size_t count) const {
    for (std::size_t got = 0; got < count;) {
      if (stop_) return false;
      if (!waits(socket)) continue;
      const auto more = ::recv(socket, to + got, static_cast<ByteCount>(count - got), 0);
      if (more <= 0) return false;
      got += static_cast<std::size_t>(more);
    }
    return true;
  }
  static void write(ServerSocket socket, const std::string& bytes) {
    (void)!::send(socket, bytes.data(), static_cast<ByteCount>(bytes.size()), kNoSignal);
  }

  static std::string frame(const std::string& text, unsigned first = 0x81, bool masked = false) {
    std::string out(1, static_cast<char>(first));
    const unsigned mask = masked ? 0x80 : 0;
    if (text.size() < 126) return out + static_cast<char>(mask | text.size()) + (masked ? std::string(4, '\0') : "") + text;
    out += static_cast<char>(mask | 126);
    out += static_cast<char>(text.size() >> 8);
    out += static_cast<char>(text.size() & 0xff);
    return out + (masked ? std::string(4, '\0') : "") + text;
  }

  std::string state(bool first) const {
    char numbers[256];
    if (mode == kNan)
      std::snprintf(numbers, sizeof numbers, R"("x":NaN,"y":1e400,"z":-inf)");
    else
      std::snprintf(numbers, sizeof numbers, R"("x":%.9g,"y":%.9g,"z":%.9g)", x.load(), y.load(), z.load());
    const char* id = mode == kWrongDevice ? "0BAD" : "04D1";
    std::string text = std::string(R"({"new_in_3_5":{"a":[1,{"b":"\"]}"}]},"inverse3":[{"device_id":")") + id + "\"," +
                       (first ? R"("config":{"handedness":"right","gravity":9.81},)" : "") + R"("state":{"cursor_position":{)" + numbers +
                       R"(},"cursor_velocity":{"x":9,"y":9,"z":9}}}],)";
    if (mode != kNoGrip)
      text +=
          std::string(R"("wireless_verse_grip":[{"device_id":"7","state":{"orientation":{"x":0,"y":0,"z":0.6,"w":0.8},"buttons":{"a":)") +
          (buttons & 1 ? "true" : "false") + R"(,"b":)" + (buttons & 2 ? "true" : "false") + R"(,"c":false}}}],)";
    return text + R"("last":null})";
  }

  void reply(ServerSocket socket, bool first) {
    const std::string whole = frame(state(first));
    switch (mode.load()) {
      case kDrop:
        return;
      case kSplit:
        for (const char byte : whole) write(socket, std::string(1, byte));
        return;
      case kFragments: {
        const std::string text = state(first);
        write(socket, frame(text.substr(0, 50), 0x01));
        write(socket, frame("hello", 0x89));  // a ping between two fragments is allowed
        write(socket, frame(text.substr(50, 40), 0x00));
        return write(socket, frame(text.substr(90), 0x80));
      }
      case kHuge:
        return write(socket, std::string("\x81\x7f\0\0\0\0\x10\0\0\0", 10) + std::string(1 << 16, 'x'));
      case kGarbage:
        return write(socket, frame(R"({"inverse3":[{"device_id":"04D1","state":{"cursor_position":{"x":1,)"));
      case kPing:
        write(socket, frame("hello", 0x89));
        return write(socket, whole);
      case kClose:
        return write(socket, frame("", 0x88));
      case kMasked:
        return write(socket, frame(state(first), 0x81, true));
      default:
        return write(socket, whole);
    }
  }

  void serve(ServerSocket socket) {
    std::string request;
    for (char byte = 0; !request.ends_with("\r\n\r\n");) {
      if (!read(socket, &byte, 1)) return;
      request += byte;
    }
    if (mode == kNotWebSocket) return write(socket, "HTTP/1.1 404 Not Found\r\n\r\n");
    write(socket, "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nSec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n\r\n");
    reply(socket, true);
    for (std::array<char, 4> head{}; read(socket, head.data(), 2);) {
      std::size_t size = static_cast<unsigned char>(head[1]) & 0x7f;
      if (!(head[1] & 0x80)) ++unmasked;
      if (size == 126) {
        if (!read(socket, head.data() + 2, 2)) return;
        size = static_cast<std::size_t>(static_cast<unsigned char>(head[2])) << 8 | static_cast<unsigned char>(head[3]);
      }
      std::array<char, 4> mask{};
      std::string text(size, '\0');
      if (!read(socket, mask.data(), 4) || !read(socket, text.data(), size)) return;
      for (std::size_t n = 0; n < size; ++n) text[n] = static_cast<char>(text[n] ^ mask[n % 4]);
      if ((head[0] & 0x0f) == 10) ++pongs;
      if ((head[0] & 0x0f) == 8) return;
      if ((head[0] & 0x0f) != 1) continue;
      scanJson(text, [&](std::span<const JsonStep> path, std::string_view value) {
        if (path.size() < 2 || path[path.size() - 2].key != "values") return;
        (path.back().key == "x" ? force_x : path.back().key == "y" ? force_y : force_z) = numberIn(value).value_or(1e9);
      });
      const double force = std::hypot(force_x.load(), force_y.load(), force_z.load());
      if (!(force <= largest)) largest = force;
      ++commands;
      reply(socket, false);
    }
  }

  void run() {
    while (!stop_) {
      if (!waits(listening_)) continue;
      const ServerSocket socket = ::accept(listening_, nullptr, nullptr);
      const int on = 1;
      ::setsockopt(socket, IPPROTO_TCP, TCP_NODELAY, reinterpret_cast<const char*>(&on), sizeof on);
      serve(socket);
      closeSocket(socket);
    }
  }

  ServerSocket listening_;
  std::uint16_t port_ = 0;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace spheretree::device::test

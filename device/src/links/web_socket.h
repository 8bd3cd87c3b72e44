// SPDX-License-Identifier: Apache-2.0
// The client's half of WebSocket (RFC 6455) as far as a text protocol on this machine needs it. After its construction
// nothing allocates.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace spheretree::device {

/// Finds the messages in the bytes of a connection, however these are cut.
class WebSocketReader {
 public:
  enum class Found {
    Nothing,  // more bytes are needed
    Text,     // payload() is a message
    Ping,     // payload() is to be sent back
    Close,    // the server ends the connection
    Broken,   // not WebSocket, or a message beyond kLargest: the connection is of no more use
  };
  static constexpr std::size_t kLargest = 1 << 15;  // of a message; those of a device have some hundred bytes

  WebSocketReader() : bytes_(2 * kLargest), message_(kLargest) {}

  /// Where the next bytes go, and how many came. Space is never empty after next() returned Nothing.
  std::span<char> space() noexcept;
  void received(std::size_t count) noexcept { end_ += count; }
  Found next() noexcept;
  std::string_view payload() const noexcept { return payload_; }  // valid until space() is called

 private:
  std::vector<char> bytes_, message_;  // message_: collects the fragments of one
  std::size_t begin_ = 0, end_ = 0, collected_ = 0;
  bool is_collecting_ = false, is_broken_ = false;
  std::string_view payload_;
};

enum class WebSocketSend : std::uint8_t { Text = 1, Close = 8, Pong = 10 };

inline constexpr std::size_t kFrameOverhead = 8;
/// Writes a whole frame, masked as a client must, and returns its size; 0 if `payload` is longer than 65535 bytes or
/// does not fit into `out`.
std::size_t writeFrame(WebSocketSend kind, std::string_view payload, std::uint32_t mask, std::span<char> out) noexcept;

/// The request that begins a connection, and whether `answer` (with its end, an empty line) accepts it.
std::string upgradeRequest(const std::string& host);
bool acceptsUpgrade(std::string_view answer);

}  // namespace spheretree::device

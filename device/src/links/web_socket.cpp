// SPDX-License-Identifier: Apache-2.0
#include "links/web_socket.h"

#include <algorithm>
#include <cstring>

namespace spheretree::device {
namespace {

// The key proves to the client that the server knows WebSocket. It is the one of the standard's example, with its
// answer: a random key would protect from caches between the two, of which a connection on one machine has none.
constexpr const char* kKey = "dGhlIHNhbXBsZSBub25jZQ==";
constexpr std::string_view kKeyAnswer = "s3pPLMBiTxaQ9kYGzzhZRbK+xOo=";

std::size_t unsignedAt(const char* bytes, std::size_t size) noexcept {  // big-endian
  std::size_t value = 0;
  for (std::size_t n = 0; n < size; ++n) value = value << 8 | static_cast<unsigned char>(bytes[n]);
  return value;
}

}  // namespace

std::span<char> WebSocketReader::space() noexcept {
  if (begin_ > 0) {
    std::memmove(bytes_.data(), bytes_.data() + begin_, end_ - begin_);
    end_ -= begin_;
    begin_ = 0;
  }
  return std::span(bytes_).subspan(end_);
}

WebSocketReader::Found WebSocketReader::next() noexcept {
  const auto broken = [this] {
    is_broken_ = true;
    return Found::Broken;
  };
  enum : unsigned { kContinuation = 0, kText = 1, kBinary = 2, kClose = 8, kPing = 9, kPong = 10 };
  while (!is_broken_) {
    const char* const head = bytes_.data() + begin_;
    const std::size_t available = end_ - begin_;
    if (available < 2) return Found::Nothing;
    const unsigned first = static_cast<unsigned char>(head[0]), second = static_cast<unsigned char>(head[1]);
    const bool is_final = (first & 0x80u) != 0, is_masked = (second & 0x80u) != 0;
    const unsigned kind = first & 0x0fu, short_size = second & 0x7fu;
    const std::size_t head_size = 2 + (short_size == 126 ? 2u : short_size == 127 ? 8u : 0u);
    if (is_masked || (first & 0x70u) != 0) return broken();  // servers mask nothing; there are no extensions
    if (available < head_size) return Found::Nothing;
    const std::size_t size = short_size < 126 ? short_size : unsignedAt(head + 2, head_size - 2);
    if (size > kLargest) return broken();
    if (available < head_size + size) return Found::Nothing;
    begin_ += head_size + size;
    payload_ = {head + head_size, size};
    if (kind >= kClose) {
      if (!is_final || size > 125) return broken();
      if (kind == kPing) return Found::Ping;
      if (kind == kClose) return Found::Close;
      if (kind != kPong) return broken();
      continue;
    }
    if (kind > kBinary || (kind == kContinuation) != is_collecting_) return broken();
    if (is_final && !is_collecting_) {
      if (kind == kText) return Found::Text;
      continue;  // binary messages are of no interest
    }
    if (kind != kContinuation) collected_ = 0;
    if (collected_ + size > kLargest) return broken();
    std::copy(payload_.begin(), payload_.end(), message_.begin() + static_cast<std::ptrdiff_t>(collected_));
    collected_ += size;
    is_collecting_ = !is_final;
    if (!is_final) continue;
    payload_ = {message_.data(), collected_};
    return Found::Text;
  }
  return Found::Broken;
}

std::size_t writeFrame(WebSocketSend kind, std::string_view payload, std::uint32_t mask, std::span<char> out) noexcept {
  if (payload.size() > 65535 || payload.size() + kFrameOverhead > out.size()) return 0;
  std::size_t at = 0;
  const auto put = [&](std::size_t byte) { out[at++] = static_cast<char>(byte & 0xff); };
  put(0x80u | static_cast<unsigned>(kind));
  if (payload.size() < 126) {
    put(0x80u | payload.size());
  } else {
    put(0x80u | 126u);
    put(payload.size() >> 8);
    put(payload.size());
  }
  const std::array<std::uint32_t, 4> key{mask >> 24, mask >> 16, mask >> 8, mask};
  for (const std::uint32_t byte : key) put(byte);
  for (std::size_t n = 0; n < payload.size(); ++n) put(static_cast<unsigned char>(payload[n]) ^ (key[n % 4] & 0xffu));
  return at;
}

std::string upgradeRequest(const std::string& host) {
  return "GET / HTTP/1.1\r\nHost: " + host + "\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Key: " + kKey +
         "\r\nSec-WebSocket-Version: 13\r\n\r\n";
}

bool acceptsUpgrade(std::string_view answer) {
  return answer.starts_with("HTTP/1.1 101") && answer.find(kKeyAnswer) != std::string_view::npos;
}

}  // namespace spheretree::device

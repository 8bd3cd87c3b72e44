// SPDX-License-Identifier: Apache-2.0
#include "links/web_socket.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace spheretree::device {
namespace {

using Found = WebSocketReader::Found;

/// A frame as a server sends it. `first`: the bits of its end and kind.
std::string frame(unsigned first, std::string_view payload) {
  std::string out{static_cast<char>(first)};
  if (payload.size() < 126) {
    out += static_cast<char>(payload.size());
  } else {
    out += {126, static_cast<char>(payload.size() >> 8), static_cast<char>(payload.size() & 0xff)};
  }
  return out.append(payload);
}

/// What a reader finds in `bytes`, which arrive `at_once` at a time, but for Nothing.
std::vector<std::pair<Found, std::string>> foundIn(std::string_view bytes, std::size_t at_once) {
  WebSocketReader reader;
  std::vector<std::pair<Found, std::string>> all;
  while (!bytes.empty()) {
    const std::span<char> space = reader.space();
    const std::size_t count = std::min({at_once, bytes.size(), space.size()});
    std::copy_n(bytes.begin(), count, space.begin());
    bytes.remove_prefix(count);
    reader.received(count);
    for (Found found = reader.next(); found != Found::Nothing; found = reader.next()) {
      all.emplace_back(found, found == Found::Broken ? "" : reader.payload());
      if (found == Found::Broken) return all;
    }
  }
  return all;
}

TEST(WebSocketReader, FindsTheSameHoweverTheStreamIsCut) {
  const std::string long_text(5000, 'x');
  const std::string bytes = frame(0x81, "{}") + frame(0x89, "are you there") + frame(0x01, "a ") + frame(0x8a, "") +
                            frame(0x00, "text in ") + frame(0x80, "parts") + frame(0x82, "binary") + frame(0x81, long_text) +
                            frame(0x88, "");
  const std::vector<std::pair<Found, std::string>> wanted{
      {Found::Text, "{}"}, {Found::Ping, "are you there"}, {Found::Text, "a text in parts"}, {Found::Text, long_text}, {Found::Close, ""}};
  for (const std::size_t at_once : {std::size_t{1}, std::size_t{2}, std::size_t{7}, std::size_t{100}, bytes.size()})
    EXPECT_EQ(foundIn(bytes, at_once), wanted) << at_once;
}

TEST(WebSocketReader, WhatIsNoWebSocketIsBrokenForGood) {
  const std::string whole(WebSocketReader::kLargest, 'x');
  for (const std::string& bytes :
       {std::string("\x81\x82mask{}", 8), frame(0xc1, "{}"), frame(0x83, ""), frame(0x80, "ends what has not begun"), frame(0x8b, ""),
        frame(0x01, "a") + frame(0x81, "b"), frame(0x09, "a ping in parts"), frame(0x89, std::string(126, 'x')),
        std::string("\x81\x7f\xff\xff\xff\xff\xff\xff\xff\xff", 10), frame(0x01, whole) + frame(0x80, "x")}) {
    const auto all = foundIn(bytes + frame(0x81, "{}"), 3);
    ASSERT_FALSE(all.empty());
    EXPECT_EQ(all.back().first, Found::Broken);
    EXPECT_EQ(all.size(), 1u);
  }
}

// RFC 6455, 5.7: "Hello", masked by 37 fa 21 3d.
TEST(WriteFrame, IsTheExampleOfTheStandard) {
  std::vector<char> out(100);
  ASSERT_EQ(writeFrame(WebSocketSend::Text, "Hello", 0x37fa213d, out), 11u);
  EXPECT_EQ(std::string(out.data(), 11), "\x81\x85\x37\xfa\x21\x3d\x7f\x9f\x4d\x51\x58");
}

TEST(WriteFrame, WritesAllOrNothing) {
  const std::string payload(300, 'y');
  std::vector<char> out(payload.size() + kFrameOverhead);
  EXPECT_EQ(writeFrame(WebSocketSend::Text, payload, 1, out), out.size());
  EXPECT_EQ(writeFrame(WebSocketSend::Text, payload, 1, std::span(out).first(out.size() - 1)), 0u);
  std::vector<char> large(70000);
  EXPECT_EQ(writeFrame(WebSocketSend::Text, std::string(65536, 'y'), 1, large), 0u);
}

// RFC 6455, 1.2.
TEST(Upgrade, TheAnswerOfTheStandardIsAccepted) {
  EXPECT_NE(upgradeRequest("here:1").find("Host: here:1\r\n"), std::string::npos);
  const std::string answer =
      "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
      "Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n\r\n";
  EXPECT_TRUE(acceptsUpgrade(answer));
  EXPECT_FALSE(acceptsUpgrade("HTTP/1.1 101 Switching Protocols\r\n\r\n"));
  EXPECT_FALSE(acceptsUpgrade("HTTP/1.1 403 Forbidden" + answer.substr(12)));
}

}  // namespace
}  // namespace spheretree::device

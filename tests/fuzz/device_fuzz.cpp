// SPDX-License-Identifier: Apache-2.0
// Feeds any bytes to the readers of what devices send: packets of spheretree.device/1, WebSocket, and the messages of
// Haply's service. They are refused or give values of which every byte came with the message.
#include <algorithm>
#include <cmath>

#include "fuzz/fuzz_target.h"
#include "links/haply_link.h"
#include "links/net_packet.h"
#include "links/web_socket.h"

namespace spheretree::fuzz {
namespace {

void feedWebSocket(std::string_view text, std::size_t at_once) {
  using Found = device::WebSocketReader::Found;
  device::WebSocketReader reader;
  while (!text.empty()) {
    const std::span<char> space = reader.space();
    require(!space.empty(), "there is space for more");
    const std::size_t count = std::min({at_once, text.size(), space.size()});
    std::copy_n(text.begin(), count, space.begin());
    text.remove_prefix(count);
    reader.received(count);
    for (Found found = reader.next(); found != Found::Nothing; found = reader.next()) {
      if (found == Found::Broken || found == Found::Close) return;
      require(reader.payload().size() <= device::WebSocketReader::kLargest, "a message is not too large");
      (void)device::readHaply(reader.payload(), "");
    }
  }
}

void feedHaply(std::string_view text) {
  for (const char* name : {"", "04BA"}) {
    const device::HaplyMessage message = device::readHaply(text, name);
    require(!message.has_pose || message.has_arm, "a pose belongs to an arm");
    const Configuration pose = device::poseOfHaply(message);
    require(!isFinite(pose) || std::abs(pose.orientation.norm() - 1) < 1e-12, "a pose that is finite is a pose");
  }
}

std::string frame(unsigned first, const std::string& payload) {
  std::string out{static_cast<char>(first)};
  if (payload.size() < 126)
    out += static_cast<char>(payload.size());
  else
    out += {126, static_cast<char>(payload.size() >> 8), static_cast<char>(payload.size() & 0xff)};
  return out + payload;
}

}  // namespace

std::vector<std::string> seeds() {
  const std::string haply =
      R"({"inverse3":[{"device_id":"04BA","config":{"handedness":"left"},"state":{"cursor_position":{"x":0.01,"y":-0.15,"z":0.2}}}],)"
      R"("verse_grip":[{"state":{"orientation":{"x":0,"y":0.6,"z":0,"w":0.8},"buttons":{"a":true,"b":false}}}]})";
  device::NetPacket packet;
  packet.sequence = 7;
  packet.pose.position = {1, 2, 3};
  const auto bytes = device::encoded(packet);
  return {haply, frame(0x81, haply),
          frame(0x01, haply.substr(0, 40)) + frame(0x89, "ping") + frame(0x80, haply.substr(40)) + frame(0x88, ""),
          std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size()),
          "HTTP/1.1 101 Switching Protocols\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
          "Sec-WebSocket-Accept: s3pPLMBiTxaQ9kYGzzhZRbK+xOo=\r\n\r\n"};
}

}  // namespace spheretree::fuzz

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace spheretree;
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fuzz::feedHaply(text);
  for (const std::size_t at_once : {std::size_t{1}, std::size_t{7}, std::size_t{4096}}) fuzz::feedWebSocket(text, at_once);
  (void)device::acceptsUpgrade(text);
  const std::span<const std::byte> bytes(reinterpret_cast<const std::byte*>(data), size);
  if (const std::optional<device::NetPacket> packet = device::decoded(bytes)) {
    const auto again = device::encoded(*packet);
    const bool has_nan = !isFinite(packet->pose) || !packet->wrench.force.allFinite() || !packet->wrench.torque.allFinite() ||
                         !std::isfinite(packet->temperature);
    fuzz::require(has_nan || std::equal(again.begin(), again.end(), bytes.begin(), bytes.end()), "one packet, one text");
  }
  return 0;
}

// SPDX-License-Identifier: Apache-2.0
#include "links/haply_link.h"

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "links/json_scan.h"

namespace spheretree::device {
namespace {

constexpr std::chrono::milliseconds kPatience{2000};
constexpr int kSendBuffer = 8192;    // some 40 commands: what a service that stalls still executes afterwards [bytes]
constexpr double kHaplyUnit = 1000;  // [mm/m]
constexpr std::string_view kAxes = "xyz", kButtons = "abc";

/// A name that can be put between quotes as it is.
bool isPlain(std::string_view name) {
  return !name.empty() && name.size() <= 64 &&
         std::all_of(name.begin(), name.end(), [](char c) { return c > ' ' && c < 127 && c != '"' && c != '\\'; });
}

std::size_t indexIn(std::string_view letters, std::string_view key) {
  return key.size() == 1 ? letters.find(key[0]) : std::string_view::npos;
}

std::chrono::milliseconds remaining(std::chrono::steady_clock::time_point begin) {
  using std::chrono::milliseconds;
  return std::max(milliseconds(0), kPatience - std::chrono::duration_cast<milliseconds>(std::chrono::steady_clock::now() - begin));
}

}  // namespace

HaplyMessage readHaply(std::string_view text, std::string_view device) noexcept {
  HaplyMessage found, arm;
  std::size_t arm_index = 0;
  unsigned axes = 0;
  const auto endArm = [&] {  // the id of an arm may follow its state
    if (!found.has_arm && !arm.device.empty() && (device.empty() || arm.device == device)) {
      found.has_arm = true;
      found.has_pose = axes == 7;
      found.position = arm.position;
      found.device = arm.device;
      found.handedness = arm.handedness;
    }
    arm = {};
    axes = 0;
  };
  const bool is_whole = scanJson(text, [&](std::span<const JsonStep> path, std::string_view value) {
    if (path.size() < 3) return;
    const std::string_view list = path[0].key, key = path.back().key, owner = path[path.size() - 2].key;
    const std::size_t element = path[1].index;
    if (list == "inverse3") {
      if (element != arm_index) endArm();
      arm_index = element;
      if (key == "device_id" && path.size() == 3) arm.device = value;
      if (key == "handedness") arm.handedness = value;
      const std::size_t axis = indexIn(kAxes, key);
      if (owner != "cursor_position" || axis == std::string_view::npos) return;
      arm.position[static_cast<Eigen::Index>(axis)] = numberIn(value).value_or(std::numeric_limits<double>::quiet_NaN());
      axes |= 1u << axis;
    } else if ((list == "verse_grip" || list == "wireless_verse_grip") && element == 0) {
      if (owner == "orientation") {
        const std::size_t axis = indexIn("xyzw", key);
        if (axis == std::string_view::npos) return;
        found.orientation.coeffs()[static_cast<Eigen::Index>(axis)] = numberIn(value).value_or(std::numeric_limits<double>::quiet_NaN());
        found.has_grip = true;
      } else if (owner == "buttons") {
        const std::size_t button = indexIn(kButtons, key);
        if (button != std::string_view::npos && value == "true") found.buttons |= 1u << button;
      }
    }
  });
  endArm();
  if (!is_whole) found.has_arm = found.has_pose = false;
  return found;
}

std::size_t writeHaply(std::string_view device, const Eigen::Vector3d& force, std::span<char> out) noexcept {
  const int size =
      std::snprintf(out.data(), out.size(),
                    R"({"inverse3":[{"device_id":"%.*s","commands":{"set_cursor_force":{"values":{"x":%.6g,"y":%.6g,"z":%.6g}}}}]})",
                    static_cast<int>(device.size()), device.data(), force.x(), -force.z(), force.y());
  return size > 0 && static_cast<std::size_t>(size) < out.size() ? static_cast<std::size_t>(size) : 0;
}

Configuration poseOfHaply(const HaplyMessage& message) noexcept {
  const Eigen::Vector3d& p = message.position;
  const Quaternion& q = message.orientation;
  Configuration pose;
  pose.position = kHaplyUnit * Eigen::Vector3d(p.x(), p.z(), -p.y());
  pose.orientation = Quaternion(q.w(), q.x(), q.z(), -q.y());
  const double length = pose.orientation.norm();
  constexpr double kFarOff = 0.1;
  if (std::abs(length - 1) < kFarOff)
    pose.orientation.coeffs() /= length;
  else
    pose.position.setConstant(std::numeric_limits<double>::quiet_NaN());  // not a rotation: a bad pose
  return pose;
}

HaplyLink::HaplyLink(const SocketAddress& service, const std::string& host, const std::string& device) : device_(device) {
  connectTo(service, host);
  shakeHands(host);
  awaitFirst(device);
}

HaplyLink::~HaplyLink() { write(WebSocketSend::Close, ""); }

void HaplyLink::connectTo(const SocketAddress& service, const std::string& host) {
  socket_.holdBackAtMost(kSendBuffer);
  if (const int error = socket_.connect(service, kPatience); error != 0)
    throw DeviceError(DeviceFault::NotFound, "haply: no service at " + host + ": " + socketWords(error) +
                                                 ". Start the Haply Inverse Service, or name its address (haptic-player: --haply-host)");
}

void HaplyLink::shakeHands(const std::string& host) {
  const std::string request = upgradeRequest(host);
  const auto begin = std::chrono::steady_clock::now();
  std::string answer;
  bool ok = socket_.send(request).bytes == request.size();
  constexpr std::size_t kLongest = 4096;
  // Byte by byte: what follows the empty line is the first message.
  while (ok && !answer.ends_with("\r\n\r\n")) {
    char byte = 0;
    const Transfer got = socket_.receive({&byte, 1});
    if (got.bytes == 1)
      answer += byte;
    else
      ok = got.error == kWouldWait && socket_.waitForData(remaining(begin));
    ok = ok && answer.size() < kLongest;
  }
  if (!ok || !acceptsUpgrade(answer))
    throw DeviceError(DeviceFault::NotFound,
                      "haply: what answers at " + host + " is not the Haply Inverse Service: check the port (10001 by default)");
}

/// The first message names the devices. Poses come only as replies to commands.
void HaplyLink::awaitFirst(const std::string& device) {
  const auto begin = std::chrono::steady_clock::now();
  std::string listed, handedness;
  bool has_pose = false;
  while (!has_pose && failed_ == 0 && socket_.waitForData(remaining(begin))) {
    const Transfer got = socket_.receive(reader_.space());
    if (got.bytes == 0) break;
    reader_.received(got.bytes);
    for (WebSocketReader::Found found; (found = reader_.next()) != WebSocketReader::Found::Nothing;) {
      if (found == WebSocketReader::Found::Broken || found == WebSocketReader::Found::Close) fail(EPROTO);
      if (failed_ != 0) break;
      if (found != WebSocketReader::Found::Text) continue;
      const HaplyMessage message = readHaply(reader_.payload(), device);
      if (message.has_arm && isPlain(message.device)) {
        device_ = message.device;
        if (!message.handedness.empty()) handedness = message.handedness;
        if (message.has_pose) take(message);
        has_first_ = has_pose = has_pose || message.has_pose;
        send({});  // asks for the next one
      } else if (const HaplyMessage any = readHaply(reader_.payload(), ""); any.has_arm) {
        listed = any.device;
      }
    }
  }
  if (!has_pose)
    throw DeviceError(DeviceFault::NotFound,
                      "haply: the service lists no Inverse3" + (device.empty() ? std::string() : " '" + device + "'") +
                          (listed.empty() ? "" : ", but '" + listed + "'") + ": plug it in, calibrate it, and check it in Haply Hub");
  info_.model = "Haply Inverse3" + (handedness.empty() ? std::string() : ", " + handedness + "-handed");
  info_.serial = device_;
  info_.driver = "Haply Inverse Service";
  info_.renders_torque = false;
  info_.can_step = false;
  info_.delay = 1;  // the reply to a command is read in the next step
}

bool HaplyLink::read(LinkState& state) noexcept {
  bool is_new = std::exchange(has_first_, false);
  for (int n = 0; n < kMostMessages && failed_ == 0; ++n) {
    const WebSocketReader::Found found = reader_.next();
    if (found == WebSocketReader::Found::Text) {
      const HaplyMessage message = readHaply(reader_.payload(), device_);
      if (!message.has_pose) {
        ++ignored_;
        continue;
      }
      take(message);
      is_new = true;
    } else if (found == WebSocketReader::Found::Ping) {
      write(WebSocketSend::Pong, reader_.payload());
    } else if (found == WebSocketReader::Found::Nothing) {
      const Transfer got = socket_.receive(reader_.space());
      if (got.error == kWouldWait) break;
      if (got.bytes == 0)
        fail(got.error == 0 ? ECONNRESET : got.error);
      else
        reader_.received(got.bytes);
    } else {
      fail(found == WebSocketReader::Found::Close ? ECONNRESET : EPROTO);
    }
  }
  state = last_;
  state.failed = failed_ != 0;
  state.code = failed_ != 0 ? failed_ : ignored_;
  return is_new;
}

void HaplyLink::take(const HaplyMessage& message) noexcept {
  const Configuration pose = poseOfHaply(message);
  last_.handle.position = pose.position;
  if (!message.has_grip) return;  // its last orientation stays
  last_.handle.orientation = pose.orientation;
  last_.buttons = message.buttons;
}

void HaplyLink::send(const Wrench& wrench) noexcept {
  std::array<char, 512> text;
  const std::size_t size = writeHaply(device_, wrench.force, text);
  if (size > 0) write(WebSocketSend::Text, {text.data(), size});
}

/// A frame that the connection does not take whole is finished first: until then later ones are left out.
void HaplyLink::write(WebSocketSend kind, std::string_view payload) noexcept {
  if (failed_ != 0 || !flush()) return;
  mask_ = mask_ * 1664525u + 1013904223u;
  to_send_ = writeFrame(kind, payload, mask_, outgoing_);
  sent_ = 0;
  flush();
}

bool HaplyLink::flush() noexcept {
  if (sent_ < to_send_) {
    const Transfer taken = socket_.send({outgoing_.data() + sent_, to_send_ - sent_});
    sent_ += taken.bytes;
    if (taken.error != 0 && taken.error != kWouldWait) fail(taken.error);
  }
  return sent_ == to_send_;
}

void HaplyLink::fail(int code) noexcept {
  if (failed_ == 0) failed_ = code;
}

}  // namespace spheretree::device

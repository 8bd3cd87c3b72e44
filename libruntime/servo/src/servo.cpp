// SPDX-License-Identifier: Apache-2.0
#include "spheretree/servo/servo.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <memory>
#include <string>

#include "exchange.h"
#include "spheretree/device/open_device.h"
#include "spheretree/device/real_time_thread.h"
#include "spheretree/device/simulated_device.h"
#include "spheretree/device/tool_mount.h"

namespace dev = spheretree::device;
using spheretree::Configuration;
using spheretree::servo::SeqLock, spheretree::servo::TripleBuffer;

static_assert(ST_SERVO_START_GUARD == int{dev::kStartGuard} && ST_SERVO_RAMP == int{dev::kRamp} &&
              ST_SERVO_STALE == int{dev::kStaleModel} && ST_SERVO_FORCES_OFF == int{dev::kForcesOff} &&
              ST_SERVO_RELEASED == int{dev::kReleased});
static_assert(ST_SERVO_RUNNING == static_cast<int>(dev::Phase::Running) && ST_SERVO_ENDED == static_cast<int>(dev::Phase::Ended) &&
              ST_SERVO_FAILED == static_cast<int>(dev::Phase::Failed) && ST_SERVO_HALTED == static_cast<int>(dev::Phase::Halted));

namespace {

using Numbers = std::array<double, 7>;

constexpr std::size_t kMaxBodies = 64;
constexpr double kShortestFrame = 1e-3, kLongestFrame = 0.1;  // of an engine, in which a body moves to its next pose [s]

thread_local std::string last_error;

Configuration configurationOf(const Numbers& n) { return {{n[0], n[1], n[2]}, spheretree::Quaternion(n[3], n[4], n[5], n[6])}; }

/// Finite, within 1e7 mm, with a quaternion that can be normalised.
bool isPose(const st_pose& pose) {
  double length = 0;
  for (const double q : pose.orientation_wxyz) length += q * q;
  bool ok = length > 1e-12 && std::isfinite(length);
  for (const double p : pose.position_mm) ok = ok && std::abs(p) <= 1e7;
  return ok;
}

Numbers numbersOf(const st_pose& pose) {
  const double* const q = pose.orientation_wxyz;
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  return {pose.position_mm[0], pose.position_mm[1], pose.position_mm[2], q[0] / length, q[1] / length, q[2] / length, q[3] / length};
}

st_pose poseOf(const Configuration& c) {
  return {{c.position.x(), c.position.y(), c.position.z()}, {c.orientation.w(), c.orientation.x(), c.orientation.y(), c.orientation.z()}};
}

/// A body that the engine moves.
struct MovedBody {
  std::atomic<std::uint32_t> body{0};   // 0: not used yet
  std::atomic<bool> is_unknown{false};  // the scene has no such body
  SeqLock<7> goal;
  // Of the servo loop:
  std::uint32_t version = 0;
  bool moved = false;
  double begin = 0, length = kLongestFrame;  // of the motion to the goal [s]
  Configuration from, to;

  Configuration at(double time) const {
    const double share = std::clamp((time - begin) / length, 0.0, 1.0);
    return {from.position + share * (to.position - from.position), from.orientation.slerp(share, to.orientation)};
  }
};

struct Published {
  st_servo_snapshot state;
  std::array<st_contact, ST_MAX_CONTACTS> contacts;
};

}  // namespace

struct st_servo final : dev::Renderer {
  std::unique_ptr<dev::Device> device;
  st_renderer* renderer = nullptr;
  dev::ToolMount mount;
  double engine_timeout = 0;
  std::array<MovedBody, kMaxBodies> bodies;
  std::atomic<std::uint32_t> updates{0};  // calls of st_servo_move_body()
  std::uint32_t seen_updates = 0;
  double updated = 0;  // when the last one was seen [s]
  bool is_simulated = false, asked_priority = false;
  SeqLock<7> hand;
  Numbers last_hand{};
  TripleBuffer<Published> published;

  ~st_servo() {
    device.reset();
    st_renderer_destroy(renderer);
  }

  dev::Rendered render(const dev::DeviceState& state) noexcept override {
    if (!asked_priority) asked_priority = (dev::requestRealTimeThread(), true);
    const double age = moveBodies(state.time);
    const Configuration tool = dev::toolInWorld(mount, state.handle);
    const st_pose pose = poseOf(tool);
    st_step step = ST_STEP_INIT;
    st_renderer_step(renderer, &pose, &step);
    Published& out = published.back();
    const dev::DeviceStatus status = device->status();
    out.state = {sizeof(st_servo_snapshot),
                 state.tick + 1,
                 state.time,
                 pose,
                 step.graphic_tool,
                 step.wrench,
                 state.buttons,
                 step.faults,
                 0,
                 status.safety,
                 static_cast<std::uint32_t>(status.phase),
                 status.late_ticks};
    out.contacts[0].struct_size = sizeof(st_contact);
    out.state.contacts = static_cast<std::uint32_t>(st_renderer_contacts(renderer, out.contacts.data(), out.contacts.size()));
    published.publish();
    const spheretree::Wrench wrench{Eigen::Vector3d(step.wrench.force_n), Eigen::Vector3d(step.wrench.torque_n_mm)};
    return {dev::wrenchOnHandle(mount, state.handle, wrench), age, (step.faults & ST_BAD_INPUT) != 0};
  }

  /// Moves the bodies along, and returns the age of what the engine said of them beyond its timeout. Forces that went
  /// off because of that return with the engine.
  double moveBodies(double time) noexcept {
    const std::uint32_t now = updates.load(std::memory_order_acquire);
    if (now != seen_updates) {
      if (time - updated > engine_timeout) device->rearm();
      seen_updates = now;
      updated = time;
    }
    for (MovedBody& body : bodies) {
      const std::uint32_t number = body.body.load(std::memory_order_acquire);
      if (number == 0) break;
      Numbers goal;
      if (const std::uint32_t version = body.goal.read(goal); version != 0 && version != body.version) {
        body.from = body.moved ? body.at(time) : configurationOf(goal);
        body.to = configurationOf(goal);
        body.length = body.moved ? std::clamp(time - body.begin, kShortestFrame, kLongestFrame) : kShortestFrame;
        body.begin = time;
        body.version = version;
        body.moved = true;
      }
      const st_pose pose = poseOf(body.at(time));
      if (body.moved && st_renderer_move_body(renderer, number, &pose, nullptr) != 0)
        body.is_unknown.store(true, std::memory_order_relaxed);
    }
    return seen_updates == 0 ? 0 : std::max(0.0, time - updated - engine_timeout);
  }

  /// The pose that the hand of the simulated device intends, on its handle.
  Configuration intended() noexcept {
    Numbers wish;
    if (hand.read(wish) != 0) last_hand = wish;
    return dev::handleOf(mount, configurationOf(last_hand));
  }
};

namespace {

std::unique_ptr<dev::Device> openFor(st_servo& servo, const std::string& name, const st_servo_options& o) {
  if (name == "simulated") {
    servo.is_simulated = true;
    servo.last_hand = numbersOf(poseOf(dev::toolInWorld(servo.mount, Configuration())));
    servo.hand.write(servo.last_hand);
    dev::SimulatedSettings settings;
    settings.path = [&servo](double) { return servo.intended(); };
    return std::make_unique<dev::SimulatedDevice>(settings);
  }
  if (!dev::isDeviceName(name))
    throw dev::DeviceError(dev::DeviceFault::Refused,
                           "there is no device '" + name + "': give haply, dhd, phantom, net:HOST:PORT or simulated");
  dev::OpenSettings settings;
  if (o.address) settings.haply_host = o.address;
  if (o.library) settings.dhd_library = settings.phantom.library = o.library;
  settings.allow_remote = o.allow_remote != 0;
  return dev::openDevice(name, settings);
}

std::unique_ptr<st_servo> started(st_scene* scene, const std::string& name, const st_servo_options& o) {
  const auto refuse = [](const std::string& why) { throw dev::DeviceError(dev::DeviceFault::Refused, why); };
  if (!scene) refuse("no scene was given");
  if (!(o.engine_timeout_s >= 1e-3 && o.engine_timeout_s <= 10)) refuse("engine_timeout_s: give a number from 0.001 to 10");
  if (!(o.rate_hz >= 500 && o.rate_hz <= 8000)) refuse("rate_hz: give a number from 500 to 8000");
  if (!(o.max_force_n > 0 && o.max_force_n <= 100 && o.max_torque_n_mm > 0 && o.max_torque_n_mm <= 1000))
    refuse("max_force_n and max_torque_n_mm: give numbers within (0, 100] and (0, 1000]");
  if (!isPose(o.device_in_world) || !isPose(o.tool_on_handle)) refuse("device_in_world and tool_on_handle: give finite poses");
  auto servo = std::make_unique<st_servo>();
  servo->engine_timeout = o.engine_timeout_s;
  servo->mount = {configurationOf(numbersOf(o.device_in_world)), configurationOf(numbersOf(o.tool_on_handle))};
  if (st_scene_set_step_time(scene, 1 / o.rate_hz) != 0) refuse(st_scene_error(scene));
  servo->renderer = st_renderer_create(scene, o.mode);
  if (!servo->renderer) refuse(st_scene_error(scene));
  servo->device = openFor(*servo, name, o);
  dev::SafetySettings safety;
  safety.period = 1 / o.rate_hz;
  safety.max_force = o.max_force_n;
  safety.max_torque = safety.max_torque.cwiseMin(o.max_torque_n_mm);
  safety.clutch_buttons = o.clutch_buttons;
  safety.carried_weight = o.carried_weight_n;
  servo->device->start(*servo, safety, dev::Clock::Real);
  return servo;
}

}  // namespace

extern "C" {

st_servo* st_servo_start(st_scene* scene, const char* device, const st_servo_options* options) {
  st_servo_options o = ST_SERVO_OPTIONS_INIT;
  if (options) std::memcpy(&o, options, std::min(options->struct_size, sizeof o));
  try {
    last_error.clear();
    return started(scene, device ? device : "", o).release();
  } catch (const std::exception& error) {
    try {
      last_error = error.what();
    } catch (...) {
      last_error.clear();
    }
    return nullptr;
  }
}

void st_servo_stop(st_servo* servo) {
  if (servo && servo->device) servo->device->stop();
  delete servo;
}

const char* st_servo_error(void) { return last_error.c_str(); }

const char* st_servo_device(const st_servo* servo) { return servo->device->info().model.c_str(); }

int st_servo_renders_torque(const st_servo* servo) { return servo->device->info().renders_torque; }

void st_servo_state(st_servo* servo, st_servo_snapshot* out) {
  servo->published.refresh();
  st_servo_snapshot now = servo->published.front().state;
  const dev::DeviceStatus status = servo->device->status();  // also after the last step
  now.phase = static_cast<std::uint32_t>(status.phase);
  now.safety = status.safety;
  now.late_steps = status.late_ticks;
  now.struct_size = out->struct_size;
  std::memcpy(out, &now, std::min(out->struct_size, sizeof now));
}

size_t st_servo_contacts(const st_servo* servo, st_contact* out, size_t capacity) {
  const Published& now = servo->published.front();
  const std::size_t count = now.state.contacts, size = capacity > 0 ? out[0].struct_size : 0;
  for (std::size_t n = 0; n < std::min(count, capacity); ++n) {
    st_contact contact = now.contacts[n];
    contact.struct_size = size;
    std::memcpy(reinterpret_cast<char*>(out) + n * size, &contact, std::min(size, sizeof contact));
  }
  return count;
}

int st_servo_move_body(st_servo* servo, uint32_t body, const st_pose* pose) {
  if (body == 0 || !isPose(*pose)) return -1;
  for (MovedBody& moved : servo->bodies) {
    const std::uint32_t number = moved.body.load(std::memory_order_relaxed);
    if (number != 0 && number != body) continue;
    if (moved.is_unknown.load(std::memory_order_relaxed)) return -1;
    moved.goal.write(numbersOf(*pose));
    moved.body.store(body, std::memory_order_release);
    servo->updates.fetch_add(1, std::memory_order_release);
    return 0;
  }
  return -1;
}

int st_servo_move_hand(st_servo* servo, const st_pose* tool) {
  if (!servo->is_simulated || !isPose(*tool)) return -1;
  servo->hand.write(numbersOf(*tool));
  return 0;
}

void st_servo_rearm(st_servo* servo) { servo->device->rearm(); }

}  // extern "C"

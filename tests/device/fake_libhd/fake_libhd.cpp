// SPDX-License-Identifier: Apache-2.0
#include "fake_libhd.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "spheretree/device/simulated_device.h"

using spheretree::Configuration;
using spheretree::Quaternion;
using spheretree::Wrench;
namespace sim = spheretree::device;

namespace {

constexpr std::uint32_t kHandle = 7, kInvalid = 0xffffffff;
constexpr std::size_t kRecords = 1 << 16;
constexpr double kMaxForce = 22, kContinuousForce = 3, kRampSeconds = 1;

enum Code : std::uint32_t {
  kBadEnum = 0x0100,
  kBadOperation = 0x0102,
  kBadType = 0x0103,
  kBadHandle = 0x0104,
  kDeviceFault = 0x0300,
  kTimer = 0x0304,
  kIllegalBegin = 0x0400,
  kIllegalEnd = 0x0401,
  kFrameError = 0x0402,
  kSchedulerFull = 0x0501,
};

struct ErrorInfo {
  std::uint32_t code;
  std::int32_t internal;
  std::uint32_t device;
};

struct Injected {
  long tick;
  ErrorInfo error;
};

/// The vendor's side of the loop: one step of the simulated device is one tick of the scheduler.
class Fake final : public sim::Renderer {
 public:
  explicit Fake(const FakeSettings& settings) : settings_(settings), records_(kRecords) {
    sim::SimulatedSettings device;
    device.coulomb = settings.coulomb;
    device.position_step = 0;
    device.angle_step.setZero();
    device.path = [path = settings.path](double time) {
      double p[3] = {0, 0, 0}, q[4] = {1, 0, 0, 0};
      if (path) path(time, p, q);
      return Configuration{{p[0], p[1], p[2]}, {q[0], q[1], q[2], q[3]}};
    };
    device_ = std::make_unique<sim::SimulatedDevice>(device);
    errors_.reserve(256);
    injected_.reserve(256);
    calibrated_ = settings.calibrated;
    held_ = settings.has_switch;
    sim::SafetySettings bare;
    bare.start_guard = false;
    bare.max_force = bare.force_slew = bare.torque_slew = bare.fade_speed = bare.pose_jump = bare.continuous_force = 1e6;
    bare.max_torque = bare.continuous_torque = Eigen::Vector3d::Constant(1e6);
    bare.stale_after = bare.off_after = 1e6;
    device_->start(*this, bare, sim::Clock::Stepped);
  }
  ~Fake() {
    stopThread();
    device_->stop();
  }

  // -- the rules --
  void broke(const std::string& rule) {
    if (violations_.find(rule) == std::string::npos) violations_.append(violations_.empty() ? "" : "; ").append(rule);
  }
  void called(const char* name) {
    if (!in_servo_) calls_.append(calls_.empty() ? "" : " ").append(name);
  }
  void push(std::uint32_t code, std::int32_t internal = 0) {
    const std::lock_guard lock(errors_mutex_);
    if (errors_.size() < errors_.capacity()) errors_.push_back({code, internal, kHandle});
  }
  bool open(const char* call) {
    if (!opened_) broke(std::string(call) + " without an open device");
    return opened_;
  }
  /// Calls that read and write the device belong into the servo loop while it runs.
  void fromServo(const char* call) {
    if (running_ && !in_servo_) broke(std::string(call) + " from another thread while the scheduler runs");
  }
  bool inFrame(const char* call) {
    fromServo(call);
    if (running_ && !in_frame_) push(kFrameError);
    return !running_ || in_frame_;
  }

  // -- time --
  void step() { device_->step(); }
  sim::Rendered render(const sim::DeviceState& state) noexcept override {
    state_ = state;
    framed_ = in_frame_ = false;
    FakeRecord& record = records_[static_cast<std::size_t>(ticks_) % kRecords];
    record = {};
    if (running_ && callback_) {
      in_servo_ = true;
      if (callback_.load()(argument_) == 0) callback_ = nullptr;
      if (in_frame_) broke("a callback returned inside a frame");
      in_servo_ = false;
    }
    if (!framed_ && running_ && sent_.norm() > 0) broke("the last frame left a force");
    ramp_ = running_ && force_on_ ? (ramping_ ? std::min(1.0, ramp_ + 1e-3 / kRampSeconds) : 1) : 0;
    Eigen::Vector3d force = ramp_ * sent_;
    if (clamping_ && force.norm() > kMaxForce) force *= kMaxForce / force.norm();
    const Eigen::Vector3d torque = ramp_ * sent_torque_;
    record.framed = framed_;
    std::copy_n(force.data(), 3, record.force);
    std::copy_n(torque.data(), 3, record.torque);
    ++ticks_;
    return {{force, torque}, 0, false};
  }

  // -- frames --
  void beginFrame() {
    if (framed_ || in_frame_) return push(kIllegalBegin);
    in_frame_ = true;
    set_.setZero();
    set_torque_.setZero();
  }
  void endFrame() {
    if (!in_frame_) return push(kIllegalEnd);
    in_frame_ = false;
    framed_ = true;
    sent_ = set_;
    sent_torque_ = gimbal_ ? cartesian(set_torque_) : set_torque_;
    FakeRecord& record = records_[static_cast<std::size_t>(ticks_) % kRecords];
    std::copy_n(set_.data(), 3, record.asked);
    std::copy_n(set_torque_.data(), 3, record.asked_torque);
    for (const Injected& injected : injected_)
      if (injected.tick == ticks_) push(injected.error.code, injected.error.internal);
    if (unread_) broke("errors were not drained in the servo");
    const std::lock_guard lock(errors_mutex_);
    unread_ = !errors_.empty();
  }
  /// The torque with the components `joints` along the three joint axes: solved here, whereas the device projects.
  Eigen::Vector3d cartesian(const Eigen::Vector3d& joints) const {
    const Eigen::Matrix3d base = (state_.handle.orientation * gimbalRotation().conjugate()).toRotationMatrix();
    const Eigen::Vector3d a = gimbalAngles();
    const Eigen::Matrix3d yaw = Eigen::AngleAxisd(a[0], Eigen::Vector3d::UnitY()).toRotationMatrix();
    const Eigen::Matrix3d pitch = Eigen::AngleAxisd(a[1], Eigen::Vector3d::UnitX()).toRotationMatrix();
    Eigen::Matrix3d axes;
    axes.row(0) = base * Eigen::Vector3d::UnitY();
    axes.row(1) = base * yaw * Eigen::Vector3d::UnitX();
    axes.row(2) = base * yaw * pitch * Eigen::Vector3d::UnitZ();
    return axes.inverse() * joints;
  }
  /// Joint angles of a handle on a base that never rotates.
  Eigen::Vector3d gimbalAngles() const {
    const Eigen::Matrix3d r = state_.handle.orientation.toRotationMatrix();
    return {std::atan2(r(0, 2), r(2, 2)), -std::asin(std::clamp(r(1, 2), -1.0, 1.0)), std::atan2(r(1, 0), r(1, 1))};
  }
  Quaternion gimbalRotation() const {
    const Eigen::Vector3d a = gimbalAngles();
    return spheretree::rotationOf({0, a[0], 0}) * spheretree::rotationOf({a[1], 0, 0}) * spheretree::rotationOf({0, 0, a[2]});
  }

  // -- scheduler --
  void startScheduler() {
    if (!callback_) broke("the scheduler was started before anything was scheduled");
    if (!force_on_) broke("the scheduler was started before the force output was enabled");
    if (!errors_.empty()) broke("the scheduler was started with errors unread");
    if (running_) broke("the scheduler was started twice");
    if (settings_.start_fails) return push(kTimer);
    running_ = true;
    if (settings_.stepped) return;
    stop_ = false;
    thread_ = std::thread([this] {
      auto due = std::chrono::steady_clock::now();
      while (!stop_) {
        step();
        std::this_thread::sleep_until(due += std::chrono::milliseconds(1));
      }
    });
  }
  void stopScheduler() {
    stopThread();
    if (running_) {
      for (long n = std::max(0L, ticks_ - 2); n < ticks_; ++n) {
        const FakeRecord& r = records_[static_cast<std::size_t>(n) % kRecords];
        if (r.asked[0] != 0 || r.asked[1] != 0 || r.asked[2] != 0) broke("the scheduler was stopped without some ticks of zero force");
      }
    }
    running_ = false;
    sent_.setZero();
    sent_torque_.setZero();
  }
  void stopThread() {
    stop_ = true;
    if (thread_.joinable()) thread_.join();
  }

  FakeSettings settings_;
  std::unique_ptr<sim::SimulatedDevice> device_;
  std::vector<FakeRecord> records_;
  std::mutex errors_mutex_;  // the thread that starts the scheduler reads errors while the servo runs
  std::vector<ErrorInfo> errors_;
  std::atomic<bool> unread_{false};
  std::vector<Injected> injected_;
  std::string violations_, calls_;
  sim::DeviceState state_;
  Eigen::Vector3d set_ = Eigen::Vector3d::Zero(), set_torque_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d sent_ = Eigen::Vector3d::Zero(), sent_torque_ = Eigen::Vector3d::Zero();
  std::atomic<std::uint32_t (*)(void*)> callback_{nullptr};
  void* argument_ = nullptr;
  std::atomic<long> ticks_{0};
  double ramp_ = 0;
  std::atomic<bool> running_{false}, stop_{false}, held_{false};
  std::atomic<int> buttons_{0};
  bool opened_ = false, force_on_ = false, clamping_ = false, ramping_ = false, calibrated_ = true;
  inline static thread_local bool in_servo_ = false;  // of the calling thread
  bool in_frame_ = false, framed_ = false, gimbal_ = false;
  std::thread thread_;
};

std::unique_ptr<Fake> fake;

Fake& get() {
  if (!fake) fake = std::make_unique<Fake>(FakeSettings());
  return *fake;
}

}  // namespace

extern "C" {

void fake_reset(const FakeSettings* settings) {
  fake.reset();
  fake = std::make_unique<Fake>(*settings);
}
void fake_step(int ticks) {
  for (int n = 0; n < ticks; ++n) get().step();
}
void fake_inject(long tick, std::uint32_t code, std::int32_t internal) { get().injected_.push_back({tick, {code, internal, kHandle}}); }
void fake_set(int buttons, bool held) {
  get().buttons_ = buttons;
  get().held_ = held;
}
long fake_ticks(void) { return get().ticks_; }
FakeRecord fake_record(long tick) { return get().records_[static_cast<std::size_t>(tick) % kRecords]; }
const char* fake_violations(void) { return get().violations_.c_str(); }
const char* fake_calls(void) { return get().calls_.c_str(); }
bool fake_running(void) { return get().running_; }

std::uint32_t hdInitDevice(const char* name) {
  Fake& f = get();
  f.called("hdInitDevice");
  const bool known = !name || std::strcmp(name, "Default PHANToM") == 0;
  if (f.settings_.unplugged || !known || (!name && f.settings_.null_name_fails)) {
    f.push(kDeviceFault, -5);
    return kInvalid;
  }
  f.opened_ = true;
  return kHandle;
}
void hdDisableDevice(std::uint32_t handle) {
  Fake& f = get();
  f.called("hdDisableDevice");
  if (handle != kHandle) f.push(kBadHandle);
  if (f.running_) f.broke("the device was disabled while the scheduler runs");
  if (f.callback_) f.broke("the device was disabled with a callback scheduled");
  f.open("hdDisableDevice");
  f.opened_ = f.force_on_ = false;
}
void hdMakeCurrentDevice(std::uint32_t handle) {
  get().called("hdMakeCurrentDevice");
  if (handle != kHandle) get().push(kBadHandle);
}
void hdBeginFrame(std::uint32_t handle) {
  if (handle != kHandle) get().push(kBadHandle);
  get().fromServo("hdBeginFrame");
  get().beginFrame();
}
void hdEndFrame(std::uint32_t handle) {
  if (handle != kHandle) get().push(kBadHandle);
  get().fromServo("hdEndFrame");
  get().endFrame();
}
ErrorInfo hdGetError(void) {
  Fake& f = get();
  if (f.calls_.size() < 12 || f.calls_.compare(f.calls_.size() - 10, 10, "hdGetError") != 0) f.called("hdGetError");
  const std::lock_guard lock(f.errors_mutex_);
  if (f.errors_.empty()) {
    f.unread_ = false;
    return {0, 0, kHandle};
  }
  const ErrorInfo newest = f.errors_.back();
  f.errors_.pop_back();
  return newest;
}
#ifndef FAKE_LIBHD_INCOMPLETE
const char* hdGetErrorString(std::uint32_t code) {
  return code == kDeviceFault ? "Device fault" : code == kTimer ? "Timer error" : "Some error";
}
#endif
void hdEnable(std::uint32_t what) {
  Fake& f = get();
  f.called("hdEnable");
  f.open("hdEnable");
  f.fromServo("hdEnable");
  if (what == 0x4000 && !f.calibrated_) f.broke("the force output was enabled on a device that is not calibrated");
  if (what == 0x4000)
    f.force_on_ = true;
  else if (what == 0x4001)
    f.clamping_ = true;
  else if (what == 0x4002)
    f.ramping_ = true;
  else if (what < 0x4000 || what > 0x4004)
    f.push(kBadEnum);
}
void hdGetBooleanv(std::uint32_t what, std::uint8_t* out) {
  if (get().settings_.poor) return get().push(kBadEnum);
  if (what != 0x2001) return get().push(what == 0x2052 || what == 0x2000 ? kBadType : kBadEnum);
  if (get().inFrame("hdGetBooleanv")) *out = get().held_;
}
void hdGetIntegerv(std::uint32_t what, std::int32_t* out) {
  Fake& f = get();
  f.open("hdGetIntegerv");
  if (what == 0x2554)
    *out = f.settings_.output_dof;
  else if (what == 0x2555)
    *out = f.settings_.calibration_style;
  else if (what != 0x2000)
    f.push(what == 0x2052 ? kBadType : kBadEnum);
  else if (f.inFrame("hdGetIntegerv"))
    *out = f.buttons_;
}
void hdGetDoublev(std::uint32_t what, double* out) {
  Fake& f = get();
  f.open("hdGetDoublev");
  if (what == 0x2603)
    *out = kMaxForce;
  else if (what == 0x2604)
    *out = kContinuousForce;
  else if (what == 0x2052) {
    if (!f.inFrame("hdGetDoublev")) return;
    const Eigen::Matrix3d r = f.state_.handle.orientation.toRotationMatrix();
    for (int column = 0; column < 3; ++column) {
      for (int row = 0; row < 3; ++row) out[4 * column + row] = r(row, column) * (1 + f.settings_.matrix_error * (column - 1));
      out[4 * column + 3] = 0;
      out[12 + column] = f.state_.handle.position[column];
    }
    out[15] = 1;
  } else if (what == 0x2605) {
    if (f.settings_.poor) return f.push(kBadEnum);
    if (!f.inFrame("hdGetDoublev")) return;
    const double extra = f.settings_.temperature_per_second * static_cast<double>(f.ticks_) * 1e-3;
    std::fill_n(out, f.settings_.output_dof, std::min(1.0, f.state_.temperature + extra));
  } else if (what == 0x2150) {
    if (!f.inFrame("hdGetDoublev")) return;
    const Eigen::Vector3d angles = f.gimbalAngles();
    std::copy_n(angles.data(), 3, out);
  } else {
    f.push(what == 0x2000 || what == 0x2001 ? kBadType : kBadEnum);
  }
}
void hdSetDoublev(std::uint32_t what, const double* in) {
  Fake& f = get();
  f.fromServo("hdSetDoublev");
  if (!f.in_frame_) return f.push(kFrameError);
  if (what == 0x2700) {
    f.set_ = {in[0], in[1], in[2]};
  } else if (what == 0x2701 || what == 0x2704) {
    if (f.settings_.output_dof < 6) return f.push(kBadOperation);
    f.set_torque_ = {in[0], in[1], in[2]};
    f.gimbal_ = what == 0x2704;
  } else {
    f.push(kBadEnum);
  }
}
const char* hdGetString(std::uint32_t what) {
  if (what == 0x2501) return "PHANTOM Premium 3.0 6DOF";
  if (what == 0x2502) return "4.3.3";
  if (what == 0x2504 && !get().settings_.poor) return "A3001";
  get().push(kBadEnum);
  return nullptr;
}
std::uint32_t hdCheckCalibration(void) {
  get().called("hdCheckCalibration");
  get().open("hdCheckCalibration");
  return get().calibrated_ ? 0x5000 : get().settings_.calibration_style == 2 ? 0x5001 : 0x5002;
}
void hdUpdateCalibration(std::uint32_t style) {
  Fake& f = get();
  f.called("hdUpdateCalibration");
  if (f.force_on_) f.broke("calibrated with the force output enabled");
  if (!(style & static_cast<std::uint32_t>(f.settings_.calibration_style))) f.broke("calibrated in a style that the device has not");
  if (!f.settings_.calibration_fails) f.calibrated_ = true;
}
void hdStartScheduler(void) {
  get().called("hdStartScheduler");
  get().startScheduler();
}
void hdStopScheduler(void) {
  get().called("hdStopScheduler");
  get().stopScheduler();
}
void hdSetSchedulerRate(unsigned long rate) {
  get().called("hdSetSchedulerRate");
  if (rate != 1000) get().broke("a rate other than 1 kHz");
}
unsigned long hdScheduleAsynchronous(std::uint32_t (*callback)(void*), void* argument, std::uint16_t priority) {
  Fake& f = get();
  f.called("hdScheduleAsynchronous");
  if (priority != 65535) f.broke("the servo was not scheduled at the highest priority");
  if (f.callback_) f.push(kSchedulerFull);
  f.callback_ = callback;
  f.argument_ = argument;
  return 1;
}
void hdUnschedule(unsigned long) {
  get().called("hdUnschedule");
  if (get().running_) get().broke("unscheduled while the scheduler runs");
  get().callback_ = nullptr;
}
std::uint8_t hdWaitForCompletion(unsigned long, std::uint32_t mode) {
  Fake& f = get();
  if (mode != 0) f.broke("waited without end");
  if (f.running_ && f.settings_.stepped) f.step();  // virtual time advances while the caller waits
  return f.running_ && f.callback_ ? 1 : 0;
}
std::uint8_t hdDeploymentLicense(const char* vendor, const char*, const char*) {
  if (get().opened_) get().broke("the licence came after the device");
  return std::strcmp(vendor, "nobody") != 0;
}

}  // extern "C"

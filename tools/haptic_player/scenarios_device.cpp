// SPDX-License-Identifier: GPL-3.0-or-later
// Scenarios of moving objects, of hands on a simulated device in closed loop, and of the device's safety rules.
// Distances mm, speeds mm/s; the device and its hands: docs/device.md
#include <algorithm>
#include <cmath>
#include <complex>
#include <functional>
#include <numbers>

#include "scenario.h"
#include "spheretree/device/simulated_device.h"

namespace spheretree::player {
namespace {

using runtime::Mode;
constexpr double kDegree = std::numbers::pi / 180;

// F9: rows that contradict each other.
Outcome squeezed(Bench& bench, Mode mode) {
  Outcome out;
  // A slot closes on a cylinder of diameter 10 from 14 to 9.8 and opens again, 1 mm/s.
  const Body &cylinder = bench.bodies.get("cylinder"), &wall = bench.bodies.get("wall");
  const Configuration left{{-7, 0, 0}, kUpright}, right{{7, 0, 0}, rotationOf({0, 0, std::numbers::pi})};
  Rig slot(cylinder, {{&wall, left}, {&wall, right}}, mode);
  double beyond_half = 0, force = 0;
  int unanswered = 0, unlogged = 0, steps_inside = 0;
  const auto squeeze = [&](double way, int steps) {
    for (int n = 0; n < steps; ++n) {
      slot.moveObject(0, {way, 0, 0});
      slot.moveObject(1, {-way, 0, 0});
      const runtime::StepResult r = slot.to({{0.3, 0, 0}, kUpright});
      unanswered += !isFinite(r.graphic);
      force = std::max(force, r.limited_wrench.force.norm());
      if (n % 10) continue;
      const double a = slot.spheres().at(r.graphic, 0), b = slot.spheres().at(r.graphic, 1);
      beyond_half = std::max(beyond_half, std::max(a, b) - 0.5 * (a + b));
      unlogged += std::max(a, b) > 2 * runtime::kGapTolerance && !(r.faults & (runtime::kPenetrating | runtime::kRowsConflict));
    }
  };
  squeeze(0.0005, 4200);
  squeeze(-0.0005, 4200);
  for (int n = 0; n < 100 && slot.spheres().at(slot.last().graphic) > kPenetrationPass; ++n, ++steps_inside)
    slot.to({{0.3, 0, 0}, kUpright});
  // A block jumps 2 into a ball that rests on it.
  const Body &ball = bench.bodies.get("ball"), &block = bench.bodies.get("block");
  Rig jump(ball, {{&block, {}}}, mode);
  jump.to({{0, 0, 8}, kUpright});
  jump.moveTo({0, 0, 5}, 50);
  jump.moveObject(0, {0, 0, 2});
  int recovery = 0;
  for (; recovery < 100; ++recovery) {
    const runtime::StepResult r = jump.to({{0, 0, 5}, kUpright});
    unanswered += !isFinite(r.graphic);
    force = std::max(force, r.limited_wrench.force.norm());
    if (jump.spheres().at(r.graphic) <= kPenetrationPass) break;
  }
  out.add("steps without an answer", "1", unanswered, 0);
  out.add("penetration beyond half of the forced overlap", "mm", beyond_half, kPenetrationPass);
  out.add("force after the limit", "N", force, 8 + 1e-9);
  out.add("steps inside that no fault bit reports", "1", unlogged, 0);
  out.add("time to come out once the slot is open", "ms", steps_inside, 50);
  out.add("time to come out of a block that jumped 2 mm", "ms", recovery, 50);
  slot.finish(out);
  return out;
}

/// Runs the runtime behind a device and keeps what it is asked.
class LoopRenderer final : public device::Renderer {
 public:
  explicit LoopRenderer(Rig& rig) : rig_(rig) {}
  device::Rendered render(const device::DeviceState& state) noexcept override {
    const runtime::StepResult r = rig_.to(state.tool);
    return {r.wrench, 0, false};
  }

 private:
  Rig& rig_;
};

struct ClosedLoop {
  std::vector<Wrench> sent;          // what the motors gave, step by step
  std::vector<Configuration> poses;  // true
  double energy = 0, lowest_energy = 0, leak = 0;
};

/// A hand on the simulated device against the rig's scene, without ramp: a bench asks for the renderer's own behaviour.
ClosedLoop runHand(Rig& rig, const device::SimulatedSettings& settings, int steps) {
  device::SimulatedDevice simulated(settings);
  LoopRenderer renderer(rig);
  device::SafetySettings safety;
  safety.start_guard = false;
  safety.max_force = 22;
  safety.force_slew = safety.torque_slew = 1e5;
  safety.ramp_force_slew = safety.ramp_torque_slew = 1e5;
  safety.ramp = 0.001;
  safety.fade_force = 1e5;
  simulated.start(renderer, safety, device::Clock::Stepped);
  ClosedLoop loop;
  Eigen::Vector3d last = simulated.truePose().position;
  for (int n = 0; n < steps && simulated.step(); ++n) {
    loop.sent.push_back(simulated.actuated());
    loop.poses.push_back(simulated.truePose());
    loop.lowest_energy = std::min(loop.lowest_energy, simulated.energy());
    // What a sampled and delayed spring must give away, whatever its renderer: (T / 2 + d T) v.K v T, here with T = 1 ms.
    const Eigen::Vector3d way = simulated.truePose().position - last;
    if (simulated.actuated().force.norm() > 1e-6)
      loop.leak += (0.5 + settings.delay) * way.squaredNorm() * rig.scene().coupling.translation;
    last = simulated.truePose().position;
  }
  loop.energy = simulated.energy();
  simulated.stop();
  return loop;
}

/// Root mean square of the part of `signal` (1 kHz) from 30 to 500 Hz: Welch, Hann windows of 1000 samples, half overlapping.
double roughness(const std::vector<double>& signal) {
  constexpr int kWindow = 1000, kLow = 30;
  if (signal.size() < kWindow) return 0;
  double power = 0;
  int windows = 0;
  for (std::size_t begin = 0; begin + kWindow <= signal.size(); begin += kWindow / 2, ++windows) {
    double mean = 0;
    for (int i = 0; i < kWindow; ++i) mean += signal[begin + static_cast<std::size_t>(i)] / kWindow;
    for (int k = kLow; k <= kWindow / 2; ++k) {
      std::complex<double> sum = 0;
      const std::complex<double> turn = std::polar(1.0, -2 * std::numbers::pi * k / kWindow);
      std::complex<double> phase = 1;
      for (int i = 0; i < kWindow; ++i, phase *= turn)
        sum += phase * (signal[begin + static_cast<std::size_t>(i)] - mean) * (0.5 - 0.5 * std::cos(2 * std::numbers::pi * i / kWindow));
      const double amplitude = 2 * std::abs(sum) / (0.5 * kWindow);
      power += 0.5 * amplitude * amplitude / 1.5;  // 1.5 bins: the noise width of the Hann window
    }
  }
  return std::sqrt(power / windows);
}

std::vector<double> alongZ(const std::vector<Wrench>& wrenches, std::size_t begin) {
  std::vector<double> z;
  for (std::size_t i = begin; i < wrenches.size(); ++i) z.push_back(wrenches[i].force.z());
  return z;
}

double peakToPeak(const std::vector<double>& v) {
  const auto [low, high] = std::minmax_element(v.begin(), v.end());
  return v.empty() ? 0 : *high - *low;
}

device::SimulatedSettings handAt(const char* hand, int delay, device::IntendedPath path) {
  device::SimulatedSettings settings;
  settings.hand = *device::findHand(hand);
  settings.delay = delay;
  settings.path = std::move(path);
  return settings;
}

// F16: a hand holds still on a plane, pressing with 2 N, through encoders of 0.02 mm.
Outcome encoders(Bench& bench, Mode mode) {
  Outcome out;
  const Body &ball = bench.bodies.get("ball"), &slab = bench.bodies.get("slab");
  double swing = 0, rms = 0;
  const int steps = bench.repetitions(10'000, 3000);
  for (const char* hand : {"fine", "arm"}) {
    Rig rig(ball, {{&slab, {}}}, mode);
    // Held by a spring of k, a push of 2 N means 2 N / k of intended depth beyond 2 mm of penetration.
    const double stiffness = device::findHand(hand)->stiffness / 1000, start = 9, rest = 5 + 0.5 - 2 - 2 / stiffness;
    const ClosedLoop loop = runHand(rig,
                                    handAt(hand, 0,
                                           [=](double t) {
                                             return Configuration{{0, 0, std::max(rest, start - 10 * t)}, kUpright};
                                           }),
                                    steps);
    const std::vector<double> z = alongZ(loop.sent, std::min<std::size_t>(loop.sent.size(), 2000));
    swing = std::max(swing, 1000 * peakToPeak(z));
    rms = std::max(rms, 1000 * roughness(z));
    if (hand == std::string("fine")) rig.finish(out);
  }
  out.add("force swing while held still", "mN", swing, 40);
  out.add("rms of the force from 30 to 500 Hz", "mN", rms, 10);
  return out;
}

// F19 to F21 ask the safety rules between runtime and device: the same in both modes but for the wrench that comes in.
struct ScriptedRenderer final : device::Renderer {
  std::function<device::Rendered(const device::DeviceState&)> answer;
  device::Rendered render(const device::DeviceState& state) noexcept override { return answer(state); }
};

Outcome startInContact(Bench& bench, Mode mode) {
  Outcome out;
  const Body &ball = bench.bodies.get("ball"), &slab = bench.bodies.get("slab");
  Rig rig(ball, {{&slab, {}}}, mode);
  device::Safety safety;
  Wrench last;
  double largest_rise = 0, early = 0;
  const auto drive = [&](double z, std::uint64_t tick) {
    device::DeviceState state;
    state.tick = tick;
    state.time = static_cast<double>(tick) / 1000;
    state.tool = {{0, 0, z}, kUpright};
    const Wrench sent = safety.limit(state, {rig.to(state.tool).wrench, 0, false});
    largest_rise = std::max(largest_rise, sent.force.norm() - last.force.norm());
    last = sent;
    return sent.force.norm();
  };
  runtime::resetTo({{0, 0, 8}, kUpright}, rig.workspace());  // the graphic tool starts outside, the hand 10 deep
  std::uint64_t tick = 0;
  for (; tick < 500; ++tick) early = std::max(early, drive(-5, tick));
  double z = -5;
  for (; tick < 3000; ++tick) drive(z = std::min(10.0, z + 0.02), tick);
  for (; tick < 4000; ++tick) drive(z = std::max(4.0, z - 0.02), tick);
  double after_jump = 0;
  for (int n = 0; n < 200; ++n) after_jump = std::max(after_jump, drive(z - 20, tick++));  // calibration: 20 mm deeper at once
  out.add("force before the guard opens", "N", early, 0);
  out.add("largest rise of the force in a step", "N", largest_rise, 0.05);
  out.add("force while a calibration jump lasts", "N", after_jump, 0);
  out.note = "Only rises count: the cut to zero at the jump is meant.";
  rig.finish(out);
  return out;
}

Outcome overrun(Bench& bench, Mode mode) {
  Outcome out;
  const Body &ball = bench.bodies.get("ball"), &slab = bench.bodies.get("slab");
  double resume_step = 0, left = 0;
  for (const int pause : {5, 20, 200, 500}) {  // ms without a fresh answer
    Rig rig(ball, {{&slab, {}}}, mode);
    device::SafetySettings settings;
    settings.start_guard = false;
    device::Safety safety(settings);
    Wrench last, model;
    double age = 0;
    bool fresh = true;
    for (int n = 0; n < 4000 + pause + 300; ++n) {
      device::DeviceState state;
      state.tick = static_cast<std::uint64_t>(n);
      state.time = n / 1000.0;
      state.tool = {{0, 0, std::max(4.0, 8 - 0.005 * n)}, kUpright};
      fresh = n < 4000 || n >= 4000 + pause;
      if (fresh) model = rig.to(state.tool).wrench, age = 0;
      if (!fresh) age += 0.001;
      const Wrench sent = safety.limit(state, {model, age, false});
      if (n >= 4000 + pause) resume_step = std::max(resume_step, sent.force.norm() - last.force.norm());
      if (n == 4000 + pause - 1 && pause >= 200) left = std::max(left, sent.force.norm());
      last = sent;
    }
    if (pause == 200) rig.finish(out);
  }
  out.add("force step on resume", "N", resume_step, 0.1);
  out.add("force after 200 ms without a fresh model", "N", left, 0);
  return out;
}

Outcome saturation(Bench& bench, Mode mode) {
  Outcome out;
  const Body &cube = bench.bodies.get("cube"), &block = bench.bodies.get("block");
  Rig rig(cube, {{&block, {}}}, mode);
  rig.to({{0, 0, 14}, kUpright});
  rig.moveTo({4, 0, -50}, 200);
  for (int n = 0; n < 90; ++n) rig.to({{4, 0, -50}, rotationOf({0, 0, n * kDegree})});
  device::SafetySettings settings;
  settings.start_guard = false;
  settings.max_force = 22;
  settings.max_torque = {515, 515, 170};
  settings.ramp = 0.001;
  settings.force_slew = settings.torque_slew = settings.ramp_force_slew = settings.ramp_torque_slew = 1e6;
  settings.fade_force = 1e6;
  settings.pose_jump = 1e6;
  device::Safety safety(settings);
  double turned = 0, force = 0, torque = 0;
  std::uint64_t tick = 0;
  for (const RecordedStep& row : rig.rows()) {
    device::DeviceState state;
    state.tick = tick;
    state.time = static_cast<double>(tick++) / 1000;
    state.tool = row.haptic;
    const Wrench sent = safety.limit(state, {row.wrench, 0, false});
    force = std::max(force, sent.force.norm());
    const Eigen::Vector3d in_handle = row.haptic.orientation.conjugate() * sent.torque;
    torque = std::max(torque, in_handle.cwiseAbs().cwiseQuotient(Eigen::Vector3d(515, 515, 170)).maxCoeff());
    if (sent.force.norm() > 1 && row.wrench.force.norm() > 1)
      turned = std::max(turned, std::acos(std::clamp(sent.force.normalized().dot(row.wrench.force.normalized()), -1.0, 1.0)) / kDegree);
  }
  // Out at 200 mm/s: how long the force stays once the haptic tool is free and as far out as its own speed.
  int late = 0, run = 0;
  for (double z = -50; z < 30; z += 0.2) {
    const runtime::StepResult r = rig.to({{4, 0, z}, rotationOf({0, 0, 89 * kDegree})});
    const bool is_free = rig.spheres().at(rig.last().haptic) == 0;
    run = is_free && r.wrench.force.norm() > 1e-6 ? run + 1 : 0;
    late = std::max(late, run);
  }
  out.add("force sent", "N", force, 22 + 1e-9);
  out.add("torque sent over its limits", "1", torque, 1 + 1e-9);
  out.add("turn of the force by the clamp", "degree", turned, 1e-3);
  out.add("cycles by which the force outlasts the contact", "1", late, 1);
  rig.finish(out);
  return out;
}

// S1: press, hold, release on a plane, by the table's hands and delays: energy, swing, roughness.
Outcome pressHoldRelease(Bench& bench, Mode mode) {
  Outcome out;
  const Body &ball = bench.bodies.get("ball"), &slab = bench.bodies.get("slab");
  double energy = 0, swing = 0, rms = 0;
  for (const char* hand : {"arm", "fine", "light", "firm"})
    for (const int delay : {0, 1, 2}) {
      Rig rig(ball, {{&slab, {}}}, mode);
      const double stiffness = device::findHand(hand)->stiffness / 1000, depth = std::min(8.0, 2 / stiffness);
      const auto path = [=](double t) {
        const double down = std::min(0.1 * 1000 * t, 4 + depth), up = std::max(0.0, 0.1 * 1000 * (t - 2));
        return Configuration{{0, 0, 9 - down + std::min(up, 4 + depth)}, kUpright};
      };
      const ClosedLoop loop = runHand(rig, handAt(hand, delay, path), 3000);
      energy = std::max(energy, -loop.lowest_energy - 1.15 * loop.leak);
      const std::vector<double> z = alongZ({loop.sent.begin(), loop.sent.begin() + 2000}, 1000);
      swing = std::max(swing, 1000 * peakToPeak(z));
      rms = std::max(rms, 1000 * roughness(z));
      if (hand == std::string("fine") && delay == 1) rig.finish(out);
    }
  out.add("energy given beyond 1.15 of the sampling's own leak", "mJ", energy, 0.02);
  out.add("force swing while pressed", "mN", swing, 40);
  out.add("rms of the force from 30 to 500 Hz while pressed", "mN", rms, 20);
  out.note = "Hands arm, fine, light and firm; delays 0, 1 and 2 ms; with the device's friction.";
  return out;
}

// S2: a slide over the plane at 50 mm/s and about 2 N.
Outcome slide(Bench& bench, Mode mode) {
  Outcome out;
  const Body &ball = bench.bodies.get("ball"), &slab = bench.bodies.get("slab");
  double rms = 0, energy = 0;
  for (const char* hand : {"fine", "arm"})
    for (const int delay : {0, 1}) {
      Rig rig(ball, {{&slab, {}}}, mode);
      const double stiffness = device::findHand(hand)->stiffness / 1000, depth = 2 / stiffness;
      const auto path = [=](double t) {
        const double x = -30 + 50 * std::clamp(t - 1, 0.0, 1.2);
        return Configuration{{x, 0, 9 - std::min(20 * t, 4 + depth)}, kUpright};
      };
      const ClosedLoop loop = runHand(rig, handAt(hand, delay, path), 2200);
      rms = std::max(rms, 1000 * roughness(alongZ(loop.sent, 1100)));
      energy = std::max(energy, -loop.lowest_energy - 1.5 * loop.leak);
      if (hand == std::string("fine") && delay == 0) rig.finish(out);
    }
  out.add("rms of the force from 30 to 500 Hz while sliding", "mN", rms, 20);
  out.add("energy given beyond 1.5 of the sampling's own leak", "mJ", energy, 0.05);
  return out;
}

// S3: both stiffnesses doubled, one step of delay: a tap and a hold may not ring.
Outcome margin(Bench& bench, Mode mode) {
  Outcome out;
  const Body &ball = bench.bodies.get("ball"), &slab = bench.bodies.get("slab");
  double ring = 0;
  for (const char* hand : {"arm", "fine", "light", "firm"}) {
    Rig::Options options;
    options.coupling = {2, 2000};
    Rig rig(ball, {{&slab, {}}}, mode, options);
    const double stiffness = device::findHand(hand)->stiffness / 1000, depth = std::min(8.0, 2 / stiffness);
    const ClosedLoop loop = runHand(rig,
                                    handAt(hand, 1,
                                           [=](double t) {
                                             return Configuration{{0, 0, 9 - std::min(100 * t, 4 + depth)}, kUpright};
                                           }),
                                    2500);
    ring = std::max(ring, peakToPeak(alongZ(loop.sent, 1500)));
  }
  out.add("ring after 1.5 s at twice the stiffness, delay 1 ms", "N", ring, 0.1);
  return out;
}

// S4: the hand lets go while it presses.
Outcome letGo(Bench& bench, Mode mode) {
  Outcome out;
  const Body &ball = bench.bodies.get("ball"), &slab = bench.bodies.get("slab");
  Rig rig(ball, {{&slab, {}}}, mode);
  device::SimulatedSettings settings = handAt("fine", 1, [](double t) {
    return Configuration{{0, 0, 9 - std::min(20 * t, 7.5)}, kUpright};
  });
  settings.release_at = 1.5;
  const ClosedLoop loop = runHand(rig, settings, 5000);
  double speed = 0, late = 0;
  for (std::size_t n = 1501; n < loop.poses.size(); ++n) {
    const double v = 1000 * (loop.poses[n].position - loop.poses[n - 1].position).norm();
    speed = std::max(speed, v);
    if (n > 4000) late = std::max(late, v);
  }
  out.add("speed of the handle after it is let go", "mm/s", speed, 100);
  out.add("speed 2.5 s later: no growing bounce", "mm/s", late, 20);
  out.note = "Physics: a spring of 1 N/mm throws 0.159 kg off at F / sqrt(k m), 79 mm/s for each newton. The hand presses with about 1 N.";
  rig.finish(out);
  return out;
}

}  // namespace

std::vector<Scenario> deviceScenarios() {
  return {{"F9", "squeezed", "Rows without a common solution", squeezed},
          {"F16", "encoders", "Quantised encoders, held still (closed loop)", encoders},
          {"F19", "start", "Start and calibration in contact", startInContact},
          {"F20", "overrun", "Overrun and lost updates", overrun},
          {"F21", "saturation", "Saturation", saturation},
          {"S1", "press", "Press, hold, release (closed loop)", pressHoldRelease},
          {"S2", "slide", "Slide at 50 mm/s (closed loop)", slide},
          {"S3", "margin", "Twice the stiffness (closed loop)", margin},
          {"S4", "let-go", "The hand lets go (closed loop)", letGo}};
}

}  // namespace spheretree::player

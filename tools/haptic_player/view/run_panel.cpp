// SPDX-License-Identifier: GPL-3.0-or-later
#include "view/run_panel.h"

#include <cstdio>

#include "spheretree/device/safety.h"
#include "spheretree/runtime/step.h"

namespace spheretree::player {
namespace {

struct Meaning {
  std::uint32_t bit;
  const char* name;
  const char* sentence;
  bool is_fault = true;
};

constexpr Meaning kFaults[] = {
    {runtime::kPenetrating, "penetrating", "The graphic tool is inside an object by more than 1 um: the step could not move it out."},
    {runtime::kPairsFull, "pairs full", "More pairs of spheres were close than there is memory for: upper levels of the trees were used."},
    {runtime::kWorkLimit, "work limit", "The step used up its budget; the graphic tool continues in the next one."},
    {runtime::kQpStopped, "solver stopped", "The solver of the step stopped early; its answer is safe but not the best."},
    {runtime::kRowsConflict, "conflict", "The contacts contradict each other: the answer has the smallest worst violation."},
    {runtime::kBadInput, "bad input", "The pose of the hand was not finite or too far away: the tool stops, and the force decays."},
    {runtime::kTissueFrozen, "tissue frozen",
     "The solver of the soft tissue failed: the tissue moves from its last valid state by its compliance at rest."}};

constexpr Meaning kSafety[] = {
    {device::kForceClamped, "force limit", "The force was limited to the largest allowed value.", false},
    {device::kTorqueClamped, "torque limit", "The torque was limited to the largest allowed value.", false},
    {device::kSlewLimited, "rise limit", "The force rose faster than allowed; its rate was limited.", false},
    {device::kStartGuard, "start guard", "Forces are off until the requested force is nearly zero, so that a start does not jerk.", false},
    {device::kRamp, "ramp", "Forces rise gradually after a start or a release.", false},
    {device::kStaleModel, "stale", "The contacts are old, or the servo loop was late: the force fades."},
    {device::kForcesOff, "forces off", "Forces were switched off and stay off until they are armed again."},
    {device::kReleased, "released", "The button is held, or no hand holds the handle: no force.", false},
    {device::kTooFast, "too fast", "The handle was fast under a large force: the force fades."},
    {device::kWarmMotors, "warm motors", "The motors are warm: the limits are lower for a while."},
    {device::kRendererFailed, "no answer", "A step gave no valid force: the last one was held, then faded."},
    {device::kBadPose, "bad pose", "The device reported a pose that jumped or is not finite."},
    {device::kDeviceFailed, "device failed", "The device failed: no force for the rest of this run."},
    {device::kEmergencyStop, "stopped", "Emergency stop: no force for the rest of this run."}};

template <std::size_t N>
std::vector<view::Lamp> lampsOf(const Meaning (&meanings)[N], std::uint32_t now, std::uint32_t so_far) {
  std::vector<view::Lamp> out;
  for (const Meaning& m : meanings) out.push_back({m.name, m.sentence, (now & m.bit) != 0, (so_far & m.bit) != 0, m.is_fault});
  return out;
}

std::string text(const char* format, double value) {
  char buffer[48];
  std::snprintf(buffer, sizeof buffer, format, value);
  return buffer;
}

}  // namespace

std::vector<view::FigureLine> figuresOf(const RecordedStep& step, const view::StepTimes& times) {
  const double pressed = (step.haptic.position - step.graphic.position).norm();
  return {{"time", text("%.3f s", step.time)},
          {"force", text("%.2f N", step.wrench.force.norm())},
          {"torque", text("%.1f N mm", step.wrench.torque.norm())},
          {"pressed in", text("%.3f mm", pressed)},
          {"penetration", text("%.1f um", 1000 * step.penetration), (step.faults & runtime::kPenetrating) != 0},
          {"friction", text("%.2f N", step.friction)},
          {"slip", text("%.1f mm/s", step.slip)},
          {"step time", text("%.0f", times.median) + " / " + text("%.0f", times.p99) + " / " + text("%.0f us", times.longest),
           times.longest > 1000},
          {"pairs, rows, active", grouped(step.pairs) + ", " + grouped(step.rows) + ", " + grouped(step.active)}};
}

std::vector<view::FigureLine> cutFigures(const RecordedStep& step, std::span<const std::string> layers) {
  return {{"burr", step.spins ? "spins" : "rests"},
          {"cuts", step.layer < layers.size() ? layers[step.layer] : "nothing"},
          {"removed", text("%.2f mm3", step.removed)}};
}

std::vector<view::Lamp> faultLamps(std::uint32_t now, std::uint32_t so_far) { return lampsOf(kFaults, now, so_far); }
std::vector<view::Lamp> safetyLamps(std::uint32_t now, std::uint32_t so_far) { return lampsOf(kSafety, now, so_far); }

std::string grouped(std::uint64_t count) {
  std::string digits = std::to_string(count);
  for (std::size_t at = digits.size(); at > 3; at -= 3) digits.insert(at - 3, ",");
  return digits;
}

}  // namespace spheretree::player

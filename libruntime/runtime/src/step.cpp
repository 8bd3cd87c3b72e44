// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/step.h"

#include "coupling_wrench.h"
#include "step_parts.h"

namespace spheretree::runtime {
namespace {

constexpr double kFarthest = 1e7;  // of a haptic pose from the origin [mm]

void forget(StepMemory& memory) {
  memory.started = memory.sides_known = false;
  for (std::size_t i = 0; i < memory.views.size(); ++i) memory.feelSkin(i);
  memory.is_behind = false;
  memory.active_count = memory.contact_count = 0;
  memory.answer = {};
  memory.depth = 0;
  memory.wrench = {};
  memory.stretch = {};
  std::fill(memory.give.begin(), memory.give.end(), 0.0);
  memory.haptic = memory.graphic = {};
  memory.euler = {};
  if (memory.tissue) memory.tissue->reset();
}

void start(const Configuration& graphic_tool, StepMemory& memory) {
  forget(memory);
  startMotions(memory);
  if (memory.bodies_move) advanceBodies(1, memory);
  if (!isFinite(graphic_tool)) return;
  memory.started = true;
  memory.haptic = memory.graphic = {graphic_tool.position, graphic_tool.orientation.normalized()};
  const Eigen::Vector3d angles = eulerAngles(memory.graphic.orientation);
  memory.euler = {angles[0], angles[1], angles[2]};
}

// Spring and damper, the latter by the change of the stretch s since the last step:  k s + c (s - s_last) / T
// = (k + c / T) (s - s_last (c / T) / (k + c / T)):  a spring alone, of the pull's stiffness, from a place that lags.
// This is Euler's implicit method, for s is what the tool has at the end of the step.
Configuration dampedAim(const Configuration& haptic, const StepMemory& memory) {
  const Coupling &coupling = memory.scene.coupling, &pull = memory.scene.pull;
  if (coupling.damping == 0 && coupling.rotation_damping == 0) return haptic;
  return moved(haptic, {(1 - coupling.translation / pull.translation) * memory.stretch.translation,
                        (1 - coupling.rotation / pull.rotation) * memory.stretch.rotation});
}

}  // namespace

StepResult step(const Scene& scene, const Configuration& haptic_tool, Mode mode, Workspace& workspace, StageTimes* times) noexcept {
  StepMemory& memory = workspace.memory();
  StepResult result;
  if (times) *times = {};
  if (!isFinite(haptic_tool) || !(haptic_tool.position.cwiseAbs().maxCoeff() <= kFarthest)) {
    result.faults = kBadInput;
    memory.wrench.force *= 0.9;
    memory.wrench.torque *= 0.9;
  } else {
    const Configuration haptic{haptic_tool.position, haptic_tool.orientation.normalized()};
    if (!memory.started) start(haptic, memory);
    if (memory.bodies.size() > 1) startMotions(memory);
    StepParts parts(memory, times, result);
    Configuration aim = haptic;
    if (mode == Mode::Paper) {
      memory.contact_count = 0;
      paperStep(parts, haptic);
    } else {
      aim = dampedAim(haptic, memory);
      if (memory.tissue) result.faults |= memory.tissue->beginStep();
      constrainedStep(parts, aim);
      memory.depth = result.penetration;
      memory.wrench = couplingWrench(memory.scene.pull, aim, memory.graphic);
      memory.stretch = displacementBetween(haptic, memory.graphic);
      const Eigen::Vector3d angles = eulerAngles(memory.graphic.orientation);
      memory.euler = {angles[0], angles[1], angles[2]};
    }
    memory.haptic = aim;
  }
  result.graphic = memory.graphic;
  result.wrench = memory.wrench;
  result.limited_wrench = limited(memory.wrench, scene.wrenchLimits());
  return result;
}

std::span<const Contact> contacts(const Workspace& workspace) noexcept {
  const StepMemory& memory = workspace.memory();
  return {memory.contacts.data(), memory.contact_count};
}

bool moveObject(std::size_t object, const Configuration& pose, Workspace& workspace) noexcept {
  StepMemory& memory = workspace.memory();
  if (object >= memory.objects.size() || !isFinite(pose) || !(pose.position.norm() <= kFarthest)) return false;
  memory.place(object, pose);
  return true;
}

bool moveBody(std::uint32_t body, const Configuration& pose, Workspace& workspace, const Displacement& velocity) noexcept {
  StepMemory& memory = workspace.memory();
  const bool is_known = body > 0 && body < memory.bodies.size();
  if (!is_known || !isFinite(pose) || !(pose.position.norm() <= kFarthest)) return false;
  if (!(velocity.translation.norm() <= kFarthest && velocity.rotation.norm() <= kFarthest)) return false;
  MovingBody& moving = memory.bodies[body];
  moving.to = {pose.position, pose.orientation.normalized()};
  moving.velocity = velocity;
  moving.has_new_pose = true;
  return true;
}

Configuration bodyPose(std::uint32_t body, const Workspace& workspace) noexcept { return workspace.memory().bodies[body].now; }

void reset(Workspace& workspace) noexcept { forget(workspace.memory()); }

void resetTo(const Configuration& graphic_tool, Workspace& workspace) noexcept { start(graphic_tool, workspace.memory()); }

}  // namespace spheretree::runtime

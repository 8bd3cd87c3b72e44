// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/step.h"

#include "state/moving_bodies.h"
#include "step/coupling_wrench.h"
#include "step/step_parts.h"

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
  memory.stretch = memory.motion = {};
  std::fill(memory.give.begin(), memory.give.end(), 0.0);
  memory.aim = memory.haptic = memory.graphic = {};
  memory.has_euler = false;
  if (memory.tissue) memory.tissue->reset();
}

// The bodies jump to their poses.
void start(const Configuration& graphic_tool, StepMemory& memory) {
  forget(memory);
  memory.started = isFinite(graphic_tool);
  if (memory.started) memory.aim = memory.haptic = memory.graphic = {graphic_tool.position, graphic_tool.orientation.normalized()};
  startMotions(memory);
  if (memory.moving_count > 0) advanceBodies(1, memory);
  for (MovingBody& body : memory.bodies) body.before = body.now;
}

// Spring, damper and mass by Euler's implicit method, where s is the stretch at the end of the step:
//   k s + c (s - s_last) / T + m (s - s_free) / T^2  =  (k + c / T + m / T^2) (s - s_aim)
// s_free is the stretch if the tool, without forces, continued its motion of the last step. The sum is a spring alone,
// with the stiffness of the pull, from a lagging position s_aim.
Configuration pulledTo(const Configuration& haptic, const StepMemory& memory, Displacement& free) {
  const CompiledScene& scene = memory.scene;
  const Coupling &coupling = scene.coupling, &pull = scene.pull, &inertia = scene.inertia;
  if (pull.translation == coupling.translation && pull.rotation == coupling.rotation) return haptic;
  free = displacementBetween(haptic, moved(memory.graphic, memory.motion));
  const auto share = [](double k, double all, double mass, const Eigen::Vector3d& last, const Eigen::Vector3d& ahead) {
    return Eigen::Vector3d((1 - (k + mass) / all) * last + mass / all * ahead);
  };
  return moved(haptic, {share(coupling.translation, pull.translation, inertia.translation, memory.stretch.translation, free.translation),
                        share(coupling.rotation, pull.rotation, inertia.rotation, memory.stretch.rotation, free.rotation)});
}

}  // namespace

Workspace::Workspace(const Scene& scene, Kernel kernel) : memory_(std::make_unique<StepMemory>(scene.compiled(), kernel)) {
  encloseBodies(*memory_);
}
Workspace::~Workspace() = default;

StepResult step(const Scene& scene, const Configuration& haptic_tool, Mode mode, Workspace& workspace, StageTimes* times) noexcept {
  StepMemory& memory = workspace.memory();
  StepResult result;
  if (times) *times = {};
  if (!isFinite(haptic_tool) || !(haptic_tool.position.cwiseAbs().maxCoeff() <= kFarthest)) {
    result.faults = kBadInput;
    memory.wrench.force *= 0.9;
    memory.wrench.torque *= 0.9;
    memory.motion = {};
  } else {
    const Configuration haptic{haptic_tool.position, haptic_tool.orientation.normalized()};
    if (!memory.started)
      start(haptic, memory);
    else if (memory.bodies.size() > 1)
      startMotions(memory);
    StepParts parts(memory, times, result);
    Configuration aim = haptic, within_cut = haptic;
    Displacement free;
    if (mode == Mode::Published) {
      memory.contact_count = 0;
      memory.stretch = memory.motion = {};
      publishedStep(parts, haptic);
    } else {
      aim = pulledTo(haptic, memory, free);
      if (memory.tissue) result.faults |= memory.tissue->beginStep(aim);
      within_cut = memory.cutting ? memory.cutting->resisted(aim, result) : aim;
      constrainedStep(parts, within_cut);
      if (memory.cutting) memory.cutting->remove(result);
      memory.depth = result.penetration;
      memory.wrench = couplingWrench(memory.scene.pull, aim, memory.graphic);
      memory.stretch = displacementBetween(haptic, memory.graphic);
      // The force that accelerates the mass does not act on the hand.
      const Coupling& inertia = memory.scene.inertia;
      memory.wrench.force -= inertia.translation * (memory.stretch.translation - free.translation);
      memory.wrench.torque -= inertia.rotation * (memory.stretch.rotation - free.rotation);
      memory.has_euler = false;
    }
    memory.aim = aim;
    memory.haptic = within_cut;
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
  placeObject(object, pose, memory);
  return true;
}

bool setActive(std::size_t object, bool is_active, Workspace& workspace) noexcept {
  StepMemory& memory = workspace.memory();
  if (object >= memory.objects.size()) return false;
  switchObject(object, is_active, memory);
  return true;
}

bool setSpindle(bool turns, Workspace& workspace) noexcept {
  Cutting* const cutting = workspace.memory().cutting.get();
  if (cutting) cutting->setSpindle(turns);
  return cutting != nullptr;
}

bool turns(const Workspace& workspace) noexcept {
  const Cutting* const cutting = workspace.memory().cutting.get();
  return cutting && cutting->spins();
}

CutState cutState(std::size_t object, const Workspace& workspace) noexcept {
  const Cutting* const cutting = workspace.memory().cutting.get();
  return cutting ? cutting->stateOf(object) : CutState{};
}

void mend(Workspace& workspace) noexcept {
  StepMemory& memory = workspace.memory();
  if (!memory.cutting) return;
  memory.cutting->mend();
  memory.sides_known = false;
}

bool isActive(std::size_t object, const Workspace& workspace) noexcept { return workspace.memory().isActive(object); }

Configuration objectPose(std::size_t object, const Workspace& workspace) noexcept {
  const StepMemory& memory = workspace.memory();
  const CompiledObject& at_home = memory.at_home[object];
  const Configuration& body = memory.bodies[at_home.body].pose();
  Configuration home;  // relative to its body
  home.orientation = Quaternion(at_home.rotation);
  home.position = at_home.anchor - at_home.rotation * memory.scene.shapes[at_home.shape].centre;
  return composed(body, home);
}

bool moveBody(std::uint32_t body, const Configuration& pose, Workspace& workspace, const Displacement& velocity) noexcept {
  StepMemory& memory = workspace.memory();
  const bool is_known = body > 0 && body < memory.bodies.size();
  if (!is_known || !isFinite(pose) || !(pose.position.norm() <= kFarthest)) return false;
  if (!(velocity.translation.norm() <= kFarthest && velocity.rotation.norm() <= kFarthest)) return false;
  MovingBody& moving = memory.bodies[body];
  moving.velocity = velocity;
  aimBody(moving, {pose.position, pose.orientation.normalized()});
  return true;
}

Configuration bodyPose(std::uint32_t body, const Workspace& workspace) noexcept { return workspace.memory().bodies[body].pose(); }

void reset(Workspace& workspace) noexcept { forget(workspace.memory()); }

void resetTo(const Configuration& graphic_tool, Workspace& workspace) noexcept { start(graphic_tool, workspace.memory()); }

}  // namespace spheretree::runtime

// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/step.h"

#include "spheretree/runtime/force.h"
#include "step_parts.h"

namespace spheretree::runtime {
namespace {

constexpr double kFarthest = 1e7;  // of a haptic pose from the origin [mm]

}  // namespace

StepResult step(const Scene& scene, const Configuration& haptic_tool, Mode mode, Workspace& workspace, StageTimes* times) noexcept {
  StepResult result;
  if (times) *times = {};
  if (!isFinite(haptic_tool) || !(haptic_tool.position.cwiseAbs().maxCoeff() <= kFarthest)) {
    result.faults = kBadInput;
    workspace.wrench.force *= 0.9;
    workspace.wrench.torque *= 0.9;
  } else {
    const Configuration haptic{haptic_tool.position, haptic_tool.orientation.normalized()};
    if (!workspace.started) resetTo(haptic, workspace);
    StepParts parts(scene, workspace, times, result);
    if (mode == Mode::Paper) {
      paperStep(parts, haptic);
    } else {
      constrainedStep(parts, haptic);
      workspace.wrench = couplingWrench(scene.coupling, haptic, workspace.graphic);
      const Eigen::Vector3d angles = eulerAngles(workspace.graphic.orientation);
      workspace.euler = {angles[0], angles[1], angles[2]};
    }
    workspace.haptic = haptic;
  }
  result.graphic = workspace.graphic;
  result.wrench = workspace.wrench;
  result.limited_wrench = limited(workspace.wrench, scene.wrench_limits);
  return result;
}

void reset(Workspace& workspace) noexcept {
  workspace.started = false;
  workspace.is_behind = false;
  workspace.active_count = 0;
  workspace.answer = {};
  workspace.wrench = {};
  workspace.haptic = workspace.graphic = {};
  workspace.euler = {};
}

void resetTo(const Configuration& graphic_tool, Workspace& workspace) noexcept {
  reset(workspace);
  if (!isFinite(graphic_tool)) return;
  workspace.started = true;
  workspace.haptic = workspace.graphic = {graphic_tool.position, graphic_tool.orientation.normalized()};
  const Eigen::Vector3d angles = eulerAngles(workspace.graphic.orientation);
  workspace.euler = {angles[0], angles[1], angles[2]};
}

}  // namespace spheretree::runtime

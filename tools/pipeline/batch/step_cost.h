// SPDX-License-Identifier: GPL-3.0-or-later
// What a servo step costs with the trees of a scene: pairs, work, time and memory, along paths of the tool that were
// recorded or that touch random places. Units: mm, us; world frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "pipeline/batch/batch_items.h"
#include "spheretree/core/rigid.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"

namespace spheretree::pipeline {

inline constexpr std::size_t kSceneContacts = 400;  // random contacts of a scene

/// Where the tool comes upon a scene: it has this orientation and comes from far out, against the direction `out`, to
/// the position.
struct ContactPose {
  Configuration at;
  Eigen::Vector3d out;
};

/// The paths of the tool whose steps are counted: recorded ones, or else one for each contact pose.
struct ToolPaths {
  std::vector<std::vector<Configuration>> recorded;  // a pose for each step; the tool starts free at the first
  std::vector<ContactPose> contacts;
  bool empty() const { return recorded.empty() && contacts.empty(); }
};

/// The trajectories or recordings in `files`. @throws what formats::readTrajectory throws.
ToolPaths readToolPaths(const std::vector<std::filesystem::path>& files);

/// `count` contacts: a random leaf of the tool upon a random leaf of a random object, from a random side, the tool
/// turned at random. Same scene and count: same contacts.
ToolPaths randomContacts(const runtime::Scene& scene, std::size_t count);

/// Follows the paths in constrained mode. The path of a contact begins where the tool, on its way out, is free of these
/// trees, and presses it in by 1 mm from there, at 0.1 mm a step. Nothing if no step is in contact.
std::optional<StepCost> measureSteps(const runtime::Scene& scene, const ToolPaths& paths, bool measure_time);

/// Time of a step as a function of what it counted, so that a budget in microseconds gives the same trees on every
/// machine. How the constants were found: docs/batch.md
double stepModel(const runtime::StepResult& step);

/// The trees of `items` as a scene for the runtime. Nothing if there is no tool or no object.
/// @throws formats::FormatError if the runtime refuses it.
std::optional<runtime::Scene> runtimeScene(const formats::SceneFile& scene, const std::vector<BatchItem>& items);

/// The same with `object` as the only object.
std::optional<runtime::Scene> runtimeScene(const formats::SceneFile& scene, const BatchItem& tool, const BatchItem& object);

}  // namespace spheretree::pipeline

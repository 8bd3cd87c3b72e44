// SPDX-License-Identifier: GPL-3.0-or-later
// The cost of a servo step with the trees of a scene: pairs, work, time and memory, along recorded tool paths or at
// random contact poses. Units: mm, us; world frame.
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

inline constexpr std::size_t kSceneContacts = 400;  // number of random contacts of a scene

/// A contact of the tool with the scene: the tool has this orientation, and approaches the position from far outside,
/// against the direction `out`.
struct ContactPose {
  Configuration at;
  Eigen::Vector3d out;
};

/// The tool paths whose steps are counted: recorded paths, otherwise one path for each contact pose.
struct ToolPaths {
  std::vector<std::vector<Configuration>> recorded;  // a pose for each step; the tool must be free at the first one
  std::vector<ContactPose> contacts;
  bool empty() const { return recorded.empty() && contacts.empty(); }
};

/// Reads the trajectories or recordings in `files`. @throws the exceptions of formats::readTrajectory.
ToolPaths readToolPaths(const std::vector<std::filesystem::path>& files);

/// `count` contacts: a random leaf of the tool touches a random leaf of a random object, from a random direction, with
/// a random orientation of the tool. Same scene and count: same contacts.
ToolPaths randomContacts(const runtime::Scene& scene, std::size_t count);

/// Follows the paths in constrained mode. The path of a contact begins where the tool, moved outward, is free of these
/// trees, and presses the tool in by 1 mm, at 0.1 mm a step. Empty if no step is in contact.
std::optional<StepCost> measureSteps(const runtime::Scene& scene, const ToolPaths& paths, bool measure_time);

/// A model of the time of a step as a function of its counts [us], so that a budget of time gives the same trees on
/// every machine. How its constants were determined: docs/batch.md
double stepModel(const runtime::StepResult& step);

/// The trees of `items` as a scene of the runtime. Empty if there is no tool or no object.
/// @throws formats::FormatError if the runtime refuses it.
std::optional<runtime::Scene> runtimeScene(const formats::SceneFile& scene, const std::vector<BatchItem>& items);

/// As above, with `object` as the only object.
std::optional<runtime::Scene> runtimeScene(const formats::SceneFile& scene, const BatchItem& tool, const BatchItem& object);

}  // namespace spheretree::pipeline

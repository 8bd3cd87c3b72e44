// SPDX-License-Identifier: GPL-3.0-or-later
// What a servo step costs with the trees of a scene: pairs, work, time and memory, for hands that were recorded or that touch at random
// places. Units: mm, us; world frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "batch/batch_items.h"
#include "spheretree/core/rigid.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"

namespace spheretree::tool {

inline constexpr std::size_t kTouches = 400;  // of a scene

/// Where the tool comes upon a scene: turned so, from far out along `out` towards `at`.
struct Touch {
  Configuration at;
  Eigen::Vector3d out;
};

/// The hands whose steps are counted: those of recordings, or else touches.
struct Hands {
  std::vector<std::vector<Configuration>> recorded;  // poses, one a step; the tool starts free at the first
  std::vector<Touch> touches;
  bool empty() const { return recorded.empty() && touches.empty(); }
};

/// The trajectories or recordings in `files`. @throws what formats::readTrajectory throws.
Hands readHands(const std::vector<std::filesystem::path>& files);

/// `count` touches: a random leaf of the tool upon a random leaf of a random object, from a random side, the tool turned at random.
/// Same scene and count: same touches.
Hands randomTouches(const runtime::Scene& scene, std::size_t count);

/// Of the steps in contact: those with a pair of leaves within the reach of the step.
struct StepCost {
  std::size_t steps = 0;
  double pairs_median = 0, pairs_p99 = 0;
  double model_us_p99 = 0;                     // stepModel() of each step: the same on every machine
  double time_us_median = 0, time_us_p99 = 0;  // processor time, the least of three runs; measured only if asked for
};

/// Runs the hands in constrained mode. A touch begins where the tool, on its way out, is free of these trees, and is pressed in by 1 mm
/// from there, at 0.1 mm a step. Nothing if no step is in contact.
std::optional<StepCost> measureSteps(const runtime::Scene& scene, const Hands& hands, bool measure_time);

/// Time of a step as a function of what it counted, so that a budget in microseconds gives the same trees on every machine. How the
/// constants were found: docs/batch.md
double stepModel(const runtime::StepResult& step);

/// The scene that the items' trees make, for the runtime; of the objects only `only`, unless it is null. Nothing if there is no tool or no
/// object. @throws formats::FormatError if the runtime refuses it.
std::optional<runtime::Scene> runtimeScene(const formats::SceneFile& scene, const std::vector<Item>& items, const Item* only = nullptr);

/// What the runtime holds for the trees of a compiled scene [bytes].
std::size_t memoryOf(const runtime::Scene& scene);

}  // namespace spheretree::tool

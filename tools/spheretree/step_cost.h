// SPDX-License-Identifier: GPL-3.0-or-later
// What a servo step costs with the trees of a scene: pairs, work, time and memory, for hands that were recorded or that touch at random.
// Units: mm, us; world frame.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <vector>

#include "batch_items.h"
#include "spheretree/core/rigid.h"
#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/step.h"

namespace spheretree::tool {

inline constexpr std::size_t kTouches = 400;  // of a scene
inline constexpr std::uint64_t kTouchSeed = 1;

/// Poses of the hand, one a step. The tool starts free at the first.
using HandMotion = std::vector<Configuration>;

/// The trajectories or recordings in `files`. @throws what formats::readTrajectory throws.
std::vector<HandMotion> readMotions(const std::vector<std::filesystem::path>& files);

/// `count` touches: a leaf of the tool comes from a random side, the tool turned at random, upon a random leaf of a random object, and is
/// pressed in by 1 mm at 0.1 mm a step. Places where the tool would have to come through something are left out: there may be fewer than
/// `count`. Same scene, count and seed: same motions.
std::vector<HandMotion> touchingMotions(const runtime::Scene& scene, std::size_t count, std::uint64_t seed);

/// Of the steps in contact: those with a pair of leaves within the reach of the step.
struct StepCost {
  std::size_t steps = 0;
  double pairs_median = 0, pairs_p99 = 0;
  double model_us_p99 = 0;                     // stepModel() of each step: the same on every machine
  double time_us_median = 0, time_us_p99 = 0;  // processor time, the least of three runs; measured only if asked for
};

/// Runs the motions in constrained mode. Nothing if no step is in contact.
std::optional<StepCost> measureSteps(const runtime::Scene& scene, const std::vector<HandMotion>& motions, bool measure_time);

/// Time of a step as a function of what it counted, so that a budget in microseconds gives the same trees on every machine. How the
/// constants were found: docs/batch.md
double stepModel(const runtime::StepResult& step);

/// The scene that the items' trees make, for the runtime; of the objects only `only`, unless it is null. Nothing if there is no tool or no
/// object. @throws formats::FormatError if the runtime refuses it.
std::optional<runtime::Scene> runtimeScene(const formats::SceneFile& scene, const std::vector<Item>& items, const Item* only = nullptr);

/// What the runtime holds for the trees of a compiled scene [bytes].
std::size_t memoryOf(const runtime::Scene& scene);

}  // namespace spheretree::tool

// SPDX-License-Identifier: Apache-2.0
// One servo step: the pose of the haptic tool in, the pose of the graphic tool and the wrench out.
// The two modes, what is guaranteed and why: docs/runtime.md
#pragma once

#include <cstdint>

#include "spheretree/runtime/scene.h"
#include "spheretree/runtime/workspace.h"

namespace spheretree::runtime {

enum class Mode : std::uint8_t {
  Constrained,  // the graphic tool never passes through anything
  Paper,        // the published algorithm
};

/// Bits. After each of them the wrench is safe to render.
enum StepFault : std::uint32_t {
  kNoFault = 0,
  kPairsFull = 1,     // more pairs than max_pairs: upper levels of the trees stood in
  kWorkLimit = 2,     // max_work was used up: the graphic tool goes on next step
  kQpStopped = 4,     // the QP stopped early
  kRowsConflict = 8,  // the rows contradict each other: the answer has the smallest worst violation
  kPenetrating = 16,  // the graphic tool is inside an object by more than kGapTolerance
  kBadInput = 32,     // the haptic pose is not finite or beyond 1e7 mm: the tool rests and the wrench decays by 10 % a step
};

inline constexpr double kGapTolerance = 1e-3;  // the graphic tool is feasible if no leaf is deeper than this [mm]

struct StepResult {
  Configuration graphic;     // reference point and orientation of the graphic tool
  Wrench wrench;             // on the hand, about the reference point of the haptic tool, world axes [N, N mm]
  Wrench limited_wrench;     // the same within WrenchLimits: what to render
  double penetration = 0;    // of the graphic tool's leaves, max(0, -gap) [mm]; constrained mode
  std::uint32_t faults = 0;  // StepFault
  std::uint32_t pairs = 0;   // of the last search
  std::uint32_t rows = 0;    // of the last QP
  std::uint32_t active = 0;  // rows that hold the tool
  std::uint32_t qp_iterations = 0;
  std::uint32_t searches = 0, linearisations = 0;
  std::uint32_t work = 0;  // in the unit of StepLimits::max_work
};

/// Time spent in the stages of one step [ns]. Reading the clock costs about 25 ns each time.
struct StageTimes {
  std::uint64_t find = 0, rows = 0, qp = 0;
};

/// The first step, and the first after reset(), puts the graphic tool at the haptic pose.
/// No allocation, lock, exception or I/O. Cost: bounded by StepLimits. Same scene, poses and mode: same bytes.
/// `times`, if given, gets the stage times.
StepResult step(const Scene& scene, const Configuration& haptic_tool, Mode mode, Workspace& workspace,
                StageTimes* times = nullptr) noexcept;

/// Forgets the last step: the next one starts at its haptic pose.
void reset(Workspace& workspace) noexcept;

/// As reset(), but the graphic tool starts at `graphic_tool`, which should be free.
void resetTo(const Configuration& graphic_tool, Workspace& workspace) noexcept;

}  // namespace spheretree::runtime

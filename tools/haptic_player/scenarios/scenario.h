// SPDX-License-Identifier: GPL-3.0-or-later
// A stability scenario: a tool, objects, a motion of the hand, and figures with their limits, in both modes of the
// runtime. The scenarios and the sources of their limits: docs/stability.md. Units: mm, N, N mm, s, rad.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bodies/scenario_shapes.h"
#include "published/renderer.h"
#include "run/run_statistics.h"
#include "scenarios/measures.h"
#include "spheretree/runtime/step.h"
#include "spheretree/tissue/moving_tissue.h"

namespace spheretree::player {

/// One figure: the measured value and the largest value that passes.
struct Figure {
  std::string quantity, unit;
  double pass;
  double value;
  bool informative = false;        // reported but not judged: it shows a limit of the model
  std::optional<double> turned{};  // the worst value on bodies that are rotated, scaled and built with other seeds
};

/// What cuts, and what it cuts: the only object of a scenario. In mm and N of the scenario, frames of the meshes.
struct Cutting {
  std::vector<Ball> burr;  // of the tool, whose spindle is along z
  runtime::CutMaterial material;
};

/// The result of a scenario in one mode.
struct Outcome {
  std::vector<Figure> figures;  // the same quantities in both modes
  std::string note;             // what physics or the model does not allow, and by how much
  std::vector<RecordedStep> recording;
  std::vector<float> penetration;  // of leaf spheres, in each recorded step [mm]
  const Body* tool = nullptr;
  std::vector<PlacedBody> objects;
  Eigen::Vector3d reference_point = Eigen::Vector3d::Zero();
  std::optional<Cutting> cutting{};

  void add(std::string quantity, std::string unit, double value, double pass) {
    figures.push_back({std::move(quantity), std::move(unit), pass, value});
  }
};

/// The extent of the runs: `share` of the repetitions in the table; and in the constrained mode kTurnedShare of them
/// again, `turned` times, on bodies that are rotated, scaled and built with other seeds.
struct ScenarioSettings {
  double share = 1;    // in (0, 1]
  int turned = 1;      // >= 0
  double rate = 1000;  // servo steps in a second, of scenarios that have has_rate [Hz]
};
inline constexpr double kTurnedShare = 0.2;

struct ScenarioContext {
  BodyLibrary& bodies;
  ScenarioSettings settings;
  builder::Progress& progress;
  /// `full` times the share, but not fewer than `min`.
  int repetitions(int full, int min) const { return std::max(min, static_cast<int>(full * settings.share)); }
};

struct Scenario {
  std::string id;     // "F1"
  std::string alias;  // "deep"
  std::string title;
  std::function<Outcome(ScenarioContext&, Mode)> run;
  bool for_all = true;    // false: it uses our runtime or builder directly, so other renderers cannot run it
  bool is_turned = true;  // false: it does not depend on the orientation
  bool has_rate = false;  // true: it runs at any rate of the servo loop
};

/// All scenarios, in the order of the table.
const std::vector<Scenario>& scenarios();

std::vector<Scenario> contactScenarios();     // penetration, ripple, edges, jumps
std::vector<Scenario> popThroughScenarios();  // thin objects
std::vector<Scenario> numericScenarios();     // rotations, rows, units
std::vector<Scenario> builderScenarios();     // hard meshes, leaves
std::vector<Scenario> deviceScenarios();      // moving objects, safety
std::vector<Scenario> rubbingScenarios();     // friction, bodies that move
std::vector<Scenario> tissueScenarios();      // soft tissue
std::vector<Scenario> cuttingScenarios();     // a burr that cuts
std::vector<Scenario> handScenarios();        // hands on the simulated device, in closed loop

/// A number for notes, with this number of significant digits.
std::string text(double value, int digits = 3);
/// Proven largest overhang of the leaves [mm].
double leafOverhang(const Body& body);

inline constexpr Eigen::Vector3d::Scalar kPenetrationPass = 0.01;  // of leaf spheres [mm]
const Quaternion kUpright(1, 0, 0, 0);

}  // namespace spheretree::player

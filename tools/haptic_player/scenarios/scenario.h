// SPDX-License-Identifier: GPL-3.0-or-later
// What a stability scenario is: a tool, objects, a motion of the hand, and figures to be reached, in both modes of the
// runtime. The scenarios and where their figures come from: docs/stability.md. Units: mm, N, N mm, s, rad.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "published/renderer.h"
#include "run_statistics.h"
#include "scenarios/measures.h"
#include "scenarios/scenario_shapes.h"
#include "spheretree/runtime/step.h"
#include "spheretree/tissue/moving_tissue.h"

namespace spheretree::player {

/// One figure: what was measured and the largest value that passes.
struct Figure {
  std::string quantity, unit;
  double pass;
  double value;
  bool informative = false;        // the model's own limit is reported, not judged
  std::optional<double> turned{};  // the worst on bodies that are turned, scaled and of other seeds
};

/// What a scenario gives in one mode.
struct Outcome {
  std::vector<Figure> figures;  // the same ones in both modes
  std::string note;             // what physics or the model forbids, and by how much
  std::vector<RecordedStep> recording;
  std::vector<float> penetration;  // of leaf spheres, of each recorded step [mm]
  const Body* tool = nullptr;
  std::vector<PlacedBody> objects;
  Eigen::Vector3d reference_point = Eigen::Vector3d::Zero();

  void add(std::string quantity, std::string unit, double value, double pass) {
    figures.push_back({std::move(quantity), std::move(unit), pass, value});
  }
};

/// How much to run: `share` of the repetitions that the table asks for; and in the constrained mode kTurnedShare of
/// them again on bodies that are turned, scaled and of other seeds, `turned` times.
struct ScenarioSettings {
  double share = 1;  // in (0, 1]
  int turned = 1;    // >= 0
};
inline constexpr double kTurnedShare = 0.2;

struct ScenarioContext {
  BodyLibrary& bodies;
  ScenarioSettings settings;
  builder::Progress& progress;
  /// `full` times the share, at least `least`.
  int repetitions(int full, int least) const { return std::max(least, static_cast<int>(full * settings.share)); }
};

struct Scenario {
  std::string id;     // "F1"
  std::string alias;  // "deep"
  std::string title;
  std::function<Outcome(ScenarioContext&, Mode)> run;
  bool for_all = true;    // false: it asks our runtime or builder itself, so that other renderers have no part in it
  bool is_turned = true;  // false: what it does has no direction
};

/// All, in the order of the table.
const std::vector<Scenario>& scenarios();

std::vector<Scenario> contactScenarios();     // penetration, ripple, edges, jumps
std::vector<Scenario> popThroughScenarios();  // thin objects
std::vector<Scenario> numericScenarios();     // rotations, rows, units
std::vector<Scenario> builderScenarios();     // hard meshes, leaves
std::vector<Scenario> deviceScenarios();      // moving objects, safety
std::vector<Scenario> rubbingScenarios();     // friction, bodies that move
std::vector<Scenario> tissueScenarios();      // soft tissue
std::vector<Scenario> handScenarios();        // hands on the simulated device, in closed loop

/// For notes: three digits, or as many as asked for.
std::string text(double value, int digits = 3);
/// How far leaves reach out at most, as proven [mm].
double leafOverhang(const Body& body);

inline constexpr Eigen::Vector3d::Scalar kPenetrationPass = 0.01;  // of leaf spheres [mm]
const Quaternion kUpright(1, 0, 0, 0);

}  // namespace spheretree::player

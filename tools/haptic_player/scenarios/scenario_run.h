// SPDX-License-Identifier: GPL-3.0-or-later
// One run of a stability scenario: a tool among objects, driven step by step, and what is measured on the way.
// Units: mm, N, N mm, s, rad.
#pragma once

#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <utility>
#include <vector>

#include "bodies/scenario_shapes.h"
#include "published/renderer.h"
#include "run/run_statistics.h"
#include "run/tissue_motion.h"
#include "scenarios/measures.h"
#include "scenarios/scenario.h"
#include "spheretree/runtime/step.h"
#include "spheretree/tissue/moving_tissue.h"

namespace spheretree::player {

/// A tool among objects in one mode, driven step by step; keeps every step, measures on the way. Poses, forces and
/// options are those of the scenario; the runtime works in the frames of the bodies (BodyFrame), with a stiffness that
/// gives the same forces there. Penetrations are mm of the runtime.
class ScenarioRun {
 public:
  struct Options {
    Eigen::Vector3d reference_point = Eigen::Vector3d::Zero();  // mesh frame of the tool
    runtime::Coupling coupling;
    double step_time = 1e-3;  // [s]
    double mesh_spacing = 0;  // > 0: the meshes are compared too, at every 10th step in contact [mm]
    bool keep_rows = true;
    runtime::ContactSurface contact = runtime::ContactSurface::Skin;  // of bodies that do not say leaves themselves
    double friction = 0;                                              // of all objects
    bool large_motion = true;                                         // of soft tissue: by a solver in lock step
    bool moving = false;                                              // each object has a body of its own: carryObject()
    std::optional<Cutting> cutting{};                                 // the tool rests on skins then
  };
  ScenarioRun(const Body& tool, std::vector<PlacedBody> objects, Mode mode, const Options& options);
  ScenarioRun(const Body& tool, std::vector<PlacedBody> objects, Mode mode) : ScenarioRun(tool, std::move(objects), mode, Options{}) {}

  /// One servo step.
  runtime::StepResult to(const Configuration& haptic);
  /// Straight from the last haptic pose at `speed` [mm/s], a step each ms; ends there exactly.
  runtime::StepResult moveTo(const Eigen::Vector3d& position, double speed);
  /// Forgets the contact; the next step starts at its pose.
  void restart();
  /// At once, as an object that is put elsewhere.
  void moveObject(std::size_t object, const Eigen::Vector3d& scenario_way);
  /// During the next step; needs Options::moving.
  void carryObject(std::size_t object, const Eigen::Vector3d& scenario_way);

  /// The spindle of a tool that cuts. In the mode of the paper nothing is cut.
  void setSpindle(bool turns);
  /// Removed of a layer so far, as the runtime states it [mm^3 of the scenario].
  double removedOf(std::size_t layer) const;
  /// Of the tool that cuts: steps in which its axis went through material.
  int passages() const { return cut_ ? cut_->passages() : 0; }

  /// What the solver of large motion does from now on: it gives no new states, or is given forces that are not finite.
  enum class Solver { Runs, Stalls, Diverges };
  void setSolver(Solver solver) { solver_ = solver; }
  /// The solver gives a state every `least` to `most` ticks from now on, drawn anew each time.
  void setStatePeriod(std::uint64_t least, std::uint64_t most) { least_period_ = least, most_period_ = most, next_state_ = tick_; }
  /// Whether the newest state that the steps have been given is said to be frozen.
  bool isFrozen() const;

  /// Of all steps, or as many as fit: the first 200,000.
  const std::vector<RecordedStep>& rows() const { return rows_; }
  std::size_t mark() const { return rows_.size(); }
  std::span<const RecordedStep> since(std::size_t mark) const { return std::span(rows_).subspan(mark); }
  const RecordedStep& last() const { return last_; }
  const runtime::Coupling& coupling() const { return options_.coupling; }
  /// mm of the runtime for each mm of the scenario.
  double scale() const { return tool_.frame.scale; }
  /// Of our own modes, in the frame of the runtime.
  const runtime::Scene& scene() const { return scene_; }
  runtime::Workspace& workspace() { return *workspace_; }
  /// Starts anew with the graphic tool here; our own modes alone.
  void resetTo(const Configuration& graphic);
  /// Of the tool's leaves at this pose, in one of the objects or (-1) all.
  double leafDepth(const Configuration& pose, int object = -1) { return leaves_.at(toRuntime(pose, tool_.frame), object); }
  /// Deepest so far; of a renderer that knows no leaves: that of the meshes; of a tool that cuts: of what does not cut;
  /// both at every 10th step [mm].
  double leafPenetration() const { return leaf_penetration_; }
  double meshPenetration() const { return mesh_penetration_; }
  const TimeHistogram& times() const { return times_; }  // processor time of the thread [us]
  const std::vector<std::uint32_t>& work() const { return work_; }
  /// Hands rows, tool and objects over to `outcome`.
  void finish(Outcome& outcome);

 private:
  static Configuration toRuntime(const Configuration& pose, const BodyFrame& frame);
  runtime::StepResult fromRuntime(runtime::StepResult result) const;
  void moveTissue();
  void describeCutting(runtime::SceneDescription& description);
  void lookAtCut(const Configuration& graphic);

  const Body& tool_;
  std::vector<PlacedBody> objects_;       // in the runtime
  std::vector<Eigen::Vector3d> carried_;  // (object) from where it was at the start, in the runtime
  Mode mode_;
  Options options_;
  runtime::Scene scene_;
  std::unique_ptr<runtime::Workspace> workspace_;
  std::unique_ptr<Renderer> renderer_;  // of a mode that is not ours
  struct MovingObject {
    std::size_t object;
    std::unique_ptr<tissue::MovingTissue> motion;
    tissue::TissueState taken, solved;  // held by the workspace; of the solver
    std::vector<float> forces;
  };
  std::vector<MovingObject> moving_;  // tissue in large motion
  Solver solver_ = Solver::Runs;
  LeafPenetration leaves_;
  std::unique_ptr<CutPenetration> cut_;  // instead of leaves_
  bool spins_ = false;
  std::unique_ptr<MeshPenetration> meshes_;
  std::vector<RecordedStep> rows_;
  std::vector<float> row_penetration_;
  std::vector<std::uint32_t> work_;
  RecordedStep last_;
  TimeHistogram times_;
  double leaf_penetration_ = 0, mesh_penetration_ = 0;
  std::uint64_t tick_ = 0, next_state_ = 0, least_period_ = kTissueTicks, most_period_ = kTissueTicks;
  std::mt19937 periods_{1};
};

/// Own generator: the same numbers with every standard library.
class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) { return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1p-53; }

 private:
  std::mt19937_64 engine_;
};

}  // namespace spheretree::player

// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <stdexcept>

#include "run/real_time.h"
#include "run/servo_loop.h"
#include "scenarios/scenario_run.h"
#include "step/coupling_wrench.h"

namespace spheretree::player {

constexpr std::size_t kMaxRows = 200'000;
constexpr double kSpacing = 0.02;  // default spacing of the points by which meshes are compared, as a share of the tool's diagonal

std::string text(double value, int digits) {
  char buffer[32];
  std::snprintf(buffer, sizeof buffer, "%.*g", digits, value);
  return buffer;
}

double leafOverhang(const Body& body) { return static_cast<double>(body.tree.statistics.back().overhang_bound); }

namespace {

// The published method uses only leaves.
runtime::ContactSurface surfaceOf(Mode mode, const std::vector<PlacedBody>& objects, runtime::ContactSurface wanted) {
  const bool all_skin =
      std::all_of(objects.begin(), objects.end(), [](const PlacedBody& o) { return o.body->contact == runtime::ContactSurface::Skin; });
  return mode != Mode::Published && all_skin && wanted == runtime::ContactSurface::Skin ? runtime::ContactSurface::Skin
                                                                                        : runtime::ContactSurface::Leaves;
}

}  // namespace

Configuration ScenarioRun::toRuntime(const Configuration& pose, const BodyFrame& frame) {
  return {frame.scale * (frame.world * pose.position), frame.world * pose.orientation * frame.turn.conjugate()};
}

runtime::StepResult ScenarioRun::fromRuntime(runtime::StepResult r) const {
  const BodyFrame& frame = tool_.frame;
  const Quaternion back = frame.world.conjugate();
  r.graphic = {(back * r.graphic.position) / frame.scale, back * r.graphic.orientation * frame.turn};
  r.wrench = {back * r.wrench.force, (back * r.wrench.torque) / frame.scale};
  r.limited_wrench = runtime::limited(r.wrench, {});
  return r;
}

ScenarioRun::ScenarioRun(const Body& tool, std::vector<PlacedBody> objects, Mode mode, const Options& options)
    : tool_(tool),
      objects_([&] {
        for (PlacedBody& object : objects) object.pose = toRuntime(object.pose, object.body->frame);
        return std::move(objects);
      }()),
      mode_(mode),
      options_(options),
      leaves_(tool.tree, tool.frame.scale * (tool.frame.turn * options.reference_point), objects_,
              surfaceOf(mode, objects_, options.contact)) {
  const double scale = tool.frame.scale;
  const Eigen::Vector3d reference_point = scale * (tool.frame.turn * options.reference_point);
  const runtime::Coupling& k = options.coupling;
  runtime::SceneDescription description;
  description.tool = tool.tree;
  description.reference_point = reference_point;
  description.step_time = options.step_time;
  description.coupling = {k.translation / scale,      k.rotation * scale, k.damping / scale,
                          k.rotation_damping * scale, k.mass / scale,     k.inertia * scale};
  carried_.resize(objects_.size(), Eigen::Vector3d::Zero());
  for (const PlacedBody& object : objects_) {
    const auto body = static_cast<std::uint32_t>(options.moving ? description.objects.size() + 1 : 0);
    const std::optional<SoftPart>& soft = object.body->soft;
    description.objects.push_back({soft ? soft->tree : object.body->tree, object.pose, body, options.friction});
    if (soft) description.objects.back().tissue = soft->model;
  }
  description.contact = surfaceOf(mode, objects_, options.contact);
  if (options.cutting) describeCutting(description);
  std::string fault;
  if (!runtime::compileScene(description, scene_, fault)) throw std::runtime_error(fault);
  workspace_ = std::make_unique<runtime::Workspace>(scene_);
  for (std::size_t i = 0; mode == Mode::Constrained && options.large_motion && i < objects_.size(); ++i) {
    if (!objects_[i].body->soft) continue;
    std::unique_ptr<tissue::MovingTissue> motion = tissue::MovingTissue::make(*scene_.tissue(i), fault);
    if (!motion) throw std::runtime_error(fault);
    const tissue::TissueState rest = motion->restState();
    moving_.push_back({i, std::move(motion), rest, rest, {}});
  }
  double spacing = scale * options.mesh_spacing;
  if (!isOurs(mode)) {
    renderer_ = makeRenderer(mode, {&tool, reference_point, objects_, description.coupling, scene_.byteCount()});
    if (spacing == 0) spacing = kSpacing * tool.field.diagonal();
  }
  if (spacing > 0) meshes_ = std::make_unique<MeshPenetration>(tool, reference_point, objects_, spacing);
}

// The same force and time remove a volume that is larger by the cube of the scale, with a burr larger by its square.
void ScenarioRun::describeCutting(runtime::SceneDescription& description) {
  const BodyFrame &frame = tool_.frame, &object_frame = objects_[0].body->frame;
  for (Ball ball : options_.cutting->burr)
    description.burr.push_back({frame.scale * (frame.turn * ball.centre), frame.scale * ball.radius});
  std::vector<Ball> burr = description.burr;
  for (Ball& ball : burr) ball.centre -= description.reference_point;
  cut_ = std::make_unique<CutPenetration>(tool_, description.reference_point, objects_[0], std::move(burr));
  if (mode_ != Mode::Constrained) return;
  runtime::CutMaterial material = options_.cutting->material;
  material.removal *= frame.scale;
  for (runtime::CutLayer& layer : material.inner) {
    TriangleMesh surface = *layer.surface;
    for (Eigen::Vector3d& p : surface.positions) p = object_frame.scale * (object_frame.turn * p);
    layer = {std::make_shared<const TriangleMesh>(std::move(surface)), layer.removal * frame.scale};
  }
  std::string fault;
  runtime::SceneObject& object = description.objects[0];
  object.cut = runtime::cutModel(object.tree, std::move(material), fault);
  if (!object.cut) throw std::runtime_error(fault);
  description.spindle_axis = frame.turn * Eigen::Vector3d::UnitZ();
  description.contact = runtime::ContactSurface::Skin;
}

void ScenarioRun::setSpindle(bool turns) {
  spins_ = turns;
  (void)runtime::setSpindle(turns, *workspace_);
}

double ScenarioRun::removedOf(std::size_t layer) const {
  return runtime::cutState(0, *workspace_).removed[layer] / std::pow(tool_.frame.scale, 3);
}

void ScenarioRun::lookAtCut(const Configuration& graphic) {
  last_.spins = spins_;
  const runtime::CutState state = runtime::cutState(0, *workspace_);
  for (std::size_t layer = 0; layer < state.removed.size(); ++layer) last_.removed += removedOf(layer);
  if (state.layer != runtime::CutState::kNone) last_.layer = state.layer;
  cut_->moveTo(graphic, spins_ && mode_ == Mode::Constrained);
  last_.penetration = tick_ % 10 == 0 ? cut_->depth() : 0;
  leaf_penetration_ = std::max(leaf_penetration_, last_.penetration);
}

// As the player in lock step: the steps take the state for the forces of the last time, and the solver gets the current
// forces.
void ScenarioRun::moveTissue() {
  if (solver_ == Solver::Stalls) return;
  for (MovingObject& soft : moving_) {
    std::swap(soft.taken, soft.solved);
    runtime::aimTissue(soft.object, soft.taken.surface, soft.taken.is_frozen, *workspace_);
    const std::span<const float> forces = runtime::tissueForces(soft.object, *workspace_);
    soft.forces.assign(forces.begin(), forces.end());
    if (solver_ == Solver::Diverges) std::fill(soft.forces.begin(), soft.forces.end(), std::numeric_limits<float>::quiet_NaN());
    soft.motion->advance(soft.forces, soft.solved);
  }
}

bool ScenarioRun::isFrozen() const {
  return std::any_of(moving_.begin(), moving_.end(), [](const MovingObject& soft) { return soft.taken.is_frozen; });
}

runtime::StepResult ScenarioRun::to(const Configuration& haptic) {
  runtime::StageTimes times;
  const Configuration there = toRuntime(haptic, tool_.frame);
  if (tick_ >= next_state_) {
    moveTissue();
    next_state_ = tick_ + least_period_ + periods_() % (most_period_ - least_period_ + 1);
  }
  const double start = threadTime();
  const runtime::StepResult raw =
      renderer_ ? renderer_->step(there) : runtime::step(scene_, there, runtimeMode(mode_), *workspace_, &times);
  const double total = threadTime() - start;
  const runtime::StepResult result = fromRuntime(raw);
  times_.add(total);
  work_.push_back(result.work);
  last_ =
      recordedStep(tick_++, haptic, result, times, total, renderer_ ? std::span<const runtime::Contact>() : runtime::contacts(*workspace_));
  double penetration = 0;
  if (cut_) {
    lookAtCut(raw.graphic);
    penetration = last_.penetration;
  } else if (result.pairs > 0 || result.active > 0) {
    if (meshes_ && tick_ % 10 == 0) mesh_penetration_ = std::max(mesh_penetration_, meshes_->at(raw.graphic));
    penetration = renderer_ ? mesh_penetration_ : leaves_.at(raw.graphic);
    leaf_penetration_ = std::max(leaf_penetration_, penetration);
  }
  if (options_.keep_rows && rows_.size() < kMaxRows) {
    rows_.push_back(last_);
    row_penetration_.push_back(static_cast<float>(penetration));
  }
  return result;
}

runtime::StepResult ScenarioRun::moveTo(const Eigen::Vector3d& position, double speed) {
  const Configuration from = last_.haptic;
  const Eigen::Vector3d way = position - from.position;
  const int steps = std::max(1, static_cast<int>(std::ceil(way.norm() / (speed / 1000) - 1e-9)));
  runtime::StepResult result;
  for (int n = 1; n <= steps; ++n) result = to({from.position + way * (double(n) / steps), from.orientation});
  return result;
}

void ScenarioRun::restart() {
  if (renderer_) renderer_->restart();
  runtime::reset(*workspace_);
}

void ScenarioRun::resetTo(const Configuration& graphic) { runtime::resetTo(toRuntime(graphic, tool_.frame), *workspace_); }

void ScenarioRun::moveObject(std::size_t object, const Eigen::Vector3d& scenario_way) {
  const Eigen::Vector3d way = tool_.frame.scale * (tool_.frame.world * scenario_way);
  objects_[object].pose.position += way;
  runtime::moveObject(object, objects_[object].pose, *workspace_);
  if (renderer_) renderer_->moveObject(object, objects_[object].pose);
  leaves_.moveObject(object, way);
  if (meshes_) meshes_->moveObject(object, way);
}

void ScenarioRun::carryObject(std::size_t object, const Eigen::Vector3d& scenario_way) {
  const Eigen::Vector3d way = tool_.frame.scale * (tool_.frame.world * scenario_way);
  objects_[object].pose.position += way;
  carried_[object] += way;
  runtime::moveBody(static_cast<std::uint32_t>(object + 1), {carried_[object], kUpright}, *workspace_);
  if (renderer_) renderer_->moveObject(object, objects_[object].pose);
  leaves_.moveObject(object, way);
  if (meshes_) meshes_->moveObject(object, way);
}

void ScenarioRun::finish(Outcome& outcome) {
  outcome.recording = std::move(rows_);
  outcome.penetration = std::move(row_penetration_);
  outcome.tool = &tool_;
  outcome.objects = objects_;
  outcome.reference_point = options_.reference_point;
  outcome.cutting = options_.cutting;
}

}  // namespace spheretree::player

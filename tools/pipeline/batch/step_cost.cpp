// SPDX-License-Identifier: GPL-3.0-or-later
#include "pipeline/batch/step_cost.h"

#include <time.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "quantile.h"
#include "search/find_pairs.h"
#include "spheretree/formats/errors.h"
#include "spheretree/formats/trajectory.h"
#include "state/step_memory.h"

namespace spheretree::pipeline {
namespace {

using Eigen::Vector3d;

constexpr double kStep = 0.1;        // distance of two poses on a contact's path: a hand at 100 mm/s [mm]
constexpr double kPress = 1;         // smallest motion of the tool after the first contact [mm]
constexpr double kSearchStep = 0.2;  // step of the search for a free pose on the way out of a contact [mm]
constexpr double kFarthest = 60;     // the end of that search [mm]
constexpr std::uint32_t kAllWork = 1u << 30;
constexpr int kRuns = 3;

/// SplitMix64: the distributions of the standard library differ between implementations.
class Random {
 public:
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  double unit() { return static_cast<double>(next() >> 11) * 0x1p-53; }
  std::size_t below(std::size_t n) { return static_cast<std::size_t>(next() % n); }
  /// A random direction, from a point in the unit ball of `N` dimensions that is not near its centre. Uses no function
  /// of the C library, since those differ.
  /// those differ.
  template <int N>
  Eigen::Matrix<double, N, 1> direction() {
    for (;;) {
      Eigen::Matrix<double, N, 1> v;
      for (int i = 0; i < N; ++i) v[i] = 2 * unit() - 1;
      const double n2 = v.squaredNorm();
      if (n2 <= 1 && n2 > 0.01) return v / std::sqrt(n2);
    }
  }

 private:
  std::uint64_t state_ = 1;
};

struct Leaf {
  Vector3d centre;
  double radius;
};

/// The leaves at their poses.
std::vector<Leaf> leavesOf(const runtime::CompiledTree& tree, const Eigen::Matrix3d& rotation, const Vector3d& anchor) {
  std::vector<Leaf> leaves;
  for (std::size_t slot = 0; slot < tree.item.size(); ++slot)
    if (tree.item[slot] != runtime::kNoItem)
      leaves.push_back(
          {anchor + rotation * Vector3d(tree.exact[slot][0], tree.exact[slot][1], tree.exact[slot][2]), tree.spheres[slot].radius});
  return leaves;
}

/// The path of a contact, from the free pose; empty if no pose on the way is free.
std::vector<Configuration> pathOf(const ContactPose& contact, runtime::Workspace& workspace) {
  const auto at = [&](double out) { return Configuration{contact.at.position + out * contact.out, contact.at.orientation}; };
  double out = 0;
  while (!runtime::findPairs(at(out), 0, runtime::PairsOf::LeavesExactly, kAllWork, workspace.memory()).pairs.empty()) {
    out += kSearchStep;
    if (out > kFarthest) return {};
  }
  std::vector<Configuration> poses;
  for (int step = 0; step * kStep <= kSearchStep + kPress; ++step) poses.push_back(at(out - step * kStep));
  return poses;
}

/// Processor time of this thread: what a dedicated servo thread would need, whatever else the machine runs.
double microsecondsNow() {
  timespec t;
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return 1e6 * static_cast<double>(t.tv_sec) + 1e-3 * static_cast<double>(t.tv_nsec);
}

}  // namespace

ToolPaths readToolPaths(const std::vector<std::filesystem::path>& files) {
  ToolPaths paths;
  for (const std::filesystem::path& file : files) paths.recorded.push_back(formats::readTrajectory(file).poses);
  return paths;
}

ToolPaths randomContacts(const runtime::Scene& scene, std::size_t count) {
  std::vector<std::vector<Leaf>> objects;
  const runtime::CompiledScene& compiled = scene.compiled();
  for (const runtime::CompiledObject& object : compiled.objects)
    objects.push_back(leavesOf(compiled.shapes[object.shape].leaves, object.rotation, object.anchor));
  const std::vector<Leaf> tool = leavesOf(compiled.tool, Eigen::Matrix3d::Identity(), Vector3d::Zero());
  Random random;
  ToolPaths paths;
  while (paths.contacts.size() < count) {
    const std::vector<Leaf>& leaves = objects[random.below(objects.size())];
    const Leaf &there = leaves[random.below(leaves.size())], &here = tool[random.below(tool.size())];
    const Vector3d out = random.direction<3>();
    const Eigen::Vector4d q = random.direction<4>();
    const Quaternion turn(q[0], q[1], q[2], q[3]);
    paths.contacts.push_back({{there.centre + there.radius * out - turn.toRotationMatrix() * here.centre, turn}, out});
  }
  return paths;
}

double stepModel(const runtime::StepResult& step) { return 0.0082 * step.work + 0.6 * step.linearisations; }

std::optional<StepCost> measureSteps(const runtime::Scene& scene, const ToolPaths& paths, bool measure_time) {
  std::vector<std::vector<Configuration>> tool_paths = paths.recorded;
  if (tool_paths.empty()) {
    runtime::Workspace workspace(scene);
    for (const ContactPose& contact : paths.contacts) tool_paths.push_back(pathOf(contact, workspace));
  }
  std::vector<double> pairs, model, micros;
  for (int run = 0; run < (measure_time ? kRuns : 1); ++run) {
    runtime::Workspace workspace(scene);
    std::size_t contact = 0;
    for (const std::vector<Configuration>& path : tool_paths) {
      runtime::reset(workspace);
      for (const Configuration& pose : path) {
        const double begun = measure_time ? microsecondsNow() : 0;
        const runtime::StepResult r = runtime::step(scene, pose, runtime::Mode::Constrained, workspace);
        const double spent = measure_time ? microsecondsNow() - begun : 0;
        if (r.pairs == 0) continue;
        if (run == 0) {
          pairs.push_back(r.pairs);
          model.push_back(stepModel(r));
          micros.push_back(spent);
        } else {
          micros[contact] = std::min(micros[contact], spent);
        }
        ++contact;
      }
    }
  }
  if (pairs.empty()) return std::nullopt;
  StepCost cost;
  cost.steps = pairs.size();
  cost.pairs_median = tool::quantile(pairs, 0.5);
  cost.pairs_p99 = tool::quantile(pairs, 0.99);
  cost.model_us_p99 = tool::quantile(model, 0.99);
  cost.time_us_median = tool::quantile(micros, 0.5);
  cost.time_us_p99 = tool::quantile(std::move(micros), 0.99);
  return cost;
}

namespace {

std::optional<runtime::Scene> compiled(const formats::SceneFile& scene, const BatchItem& tool, std::span<const BatchItem* const> objects) {
  if (!tool.hasTree() || objects.empty()) return std::nullopt;
  runtime::SceneDescription d;
  d.tool = tool.result.tree;
  for (const BatchItem* object : objects) d.objects.push_back({object->result.tree, object->source->pose});
  d.reference_point = scene.tool.reference_point_mm;
  d.coupling = {scene.translation_n_per_mm, scene.rotation_n_mm_per_rad};
  d.wrench_limits = {scene.force_n, scene.torque_n_mm};
  d.step_limits = runtime::defaultLimits(d.objects.size());
  runtime::Scene out;
  std::string fault;
  if (!runtime::compileScene(d, out, fault)) throw formats::FormatError("the scene of trees: " + fault);
  return out;
}

}  // namespace

std::optional<runtime::Scene> runtimeScene(const formats::SceneFile& scene, const std::vector<BatchItem>& items) {
  std::vector<const BatchItem*> objects;
  for (const BatchItem& item : items)
    if (!item.is_tool && item.hasTree()) objects.push_back(&item);
  return compiled(scene, items[0], objects);
}

std::optional<runtime::Scene> runtimeScene(const formats::SceneFile& scene, const BatchItem& tool, const BatchItem& object) {
  if (!object.hasTree()) return std::nullopt;
  const BatchItem* only = &object;
  return compiled(scene, tool, {&only, 1});
}

}  // namespace spheretree::pipeline

// SPDX-License-Identifier: GPL-3.0-or-later
#include "measure/evaluate_hulls.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <stdexcept>
#include <vector>

#include "geometry/box_tree.h"
#include "hulls/cut_hulls.h"
#include "hulls/hull_overhang.h"
#include "measure/coverage.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

constexpr std::size_t kSamplesATask = 4096;
constexpr double kOverhangAccuracy = 1e-3;      // of the bound above what is attained, as a share of it
constexpr std::size_t kMaxHullPieces = 100000;  // of a part, in the search for its overhang

struct Bare {
  std::size_t samples = 0;
  double gap = 0;
};

// The samples from `begin` to `end` that no part holds.
Bare bareAmong(const std::vector<SurfacePoint>& samples, std::size_t begin, std::size_t end, const BoxTree& tree,
               const std::vector<HullDistance>& parts) {
  Bare out;
  for (std::size_t i = begin; i < end; ++i) {
    const Vector3d& p = samples[i].point;
    bool is_held = false;
    tree.searchWithin(p, 0, [&](std::size_t first, std::size_t count) {
      for (std::size_t slot = first; slot < first + count && !is_held; ++slot) is_held = parts[slot](p) <= 0;
    });
    if (is_held) continue;
    ++out.samples;
    double gap = kInfinity;
    for (const HullDistance& part : parts) gap = std::min(gap, part(p));
    out.gap = std::max(out.gap, gap);
  }
  return out;
}

}  // namespace

HullEvaluation evaluateHulls(const TriangleMesh& mesh, const DistanceField& field, const Hulls& hulls, const Vector3d& origin,
                             const HullSamples& samples, Progress& progress) {
  std::vector<Hull> parts;
  std::vector<Eigen::AlignedBox3d> boxes;
  for (const HullPart& part : hulls.parts) {
    parts.push_back(hullOf(hulls, part));
    for (Ball& ball : parts.back().ball) ball.centre += origin;
    boxes.push_back(boxOf(parts.back()));
  }
  HullEvaluation out{.hulls = hulls.count, .parts = parts.size(), .balls = hulls.balls.size()};
  out.overhang_bound = hulls.overhang_bound;
  std::vector<double> attained(parts.size());
  const HullOverhangSettings search{
      .relative = kOverhangAccuracy, .absolute = kOverhangAccuracy * out.overhang_bound, .max_pieces = kMaxHullPieces};
  tbb::parallel_for(std::size_t{0}, parts.size(), [&](std::size_t i) {
    progress.check();
    attained[i] = hullOverhang(field, parts[i], search).attained;
  });
  out.overhang_max = std::max(0.0, *std::ranges::max_element(attained));
  progress.advance(0.5);

  const BoxTree tree(boxes);
  std::vector<HullDistance> distance;  // in slot order
  for (const std::uint32_t part : tree.order()) distance.emplace_back(parts[part]);
  const std::vector<SurfacePoint> points = spreadOverSurface(mesh, samples.count, samples.seed);
  if (points.empty()) throw std::invalid_argument("evaluate: the mesh has no area");
  std::vector<Bare> bare((points.size() + kSamplesATask - 1) / kSamplesATask);
  tbb::parallel_for(std::size_t{0}, bare.size(), [&](std::size_t task) {
    progress.check();
    bare[task] = bareAmong(points, task * kSamplesATask, std::min(points.size(), (task + 1) * kSamplesATask), tree, distance);
  });
  out.samples = points.size();
  for (const Bare& task : bare) out.bare_samples += task.samples, out.max_gap = std::max(out.max_gap, task.gap);
  progress.advance(1);
  return out;
}

}  // namespace spheretree::builder

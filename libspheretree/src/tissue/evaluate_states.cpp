// SPDX-License-Identifier: GPL-3.0-or-later
#include "tissue/evaluate_states.h"

#include <tbb/parallel_for.h>

#include <algorithm>

#include "base/random.h"
#include "certify/overhang_bound.h"
#include "geometry/ball_index.h"
#include "geometry/distance_field.h"

namespace spheretree::builder {

using Eigen::Vector3d;

namespace {

struct Sample {
  std::uint32_t triangle;
  std::array<double, 3> weight;
};

// Uniformly distributed by the area at rest.
std::vector<Sample> samplesOf(const TriangleMesh& surface, std::size_t count, std::uint64_t seed) {
  std::vector<double> area{0};
  for (std::size_t t = 0; t < surface.triangles.size(); ++t) {
    const Vector3d a = surface.corner(t, 0);
    area.push_back(area.back() + (surface.corner(t, 1) - a).cross(surface.corner(t, 2) - a).norm());
  }
  std::mt19937_64 random(seed);
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < count; ++i) {
    const double at = randomUnit(random) * area.back();
    const auto t = std::min<std::size_t>(static_cast<std::size_t>(std::upper_bound(area.begin(), area.end(), at) - area.begin()) - 1,
                                         surface.triangles.size() - 1);
    double u = randomUnit(random), v = randomUnit(random);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    samples.push_back({static_cast<std::uint32_t>(t), {1 - u - v, u, v}});
  }
  return samples;
}

class Evaluator {
 public:
  Evaluator(const TriangleMesh& mesh, const TriangleMesh& surface, const SphereTree& tree, const Tissue& tissue, std::size_t samples,
            std::uint64_t seed)
      : mesh_(mesh), surface_(surface), tree_(tree), tissue_(tissue), samples_(samplesOf(surface, samples, seed)) {}

  StateFigures of(const TissueState& state) const {
    StateFigures figures{state.kind, state.amount, strainOf(tissue_, state.displacements), 0, {}, 0, {}};
    std::vector<Vector3d> positions(tissue_.surface.size());
    moveSurface(tissue_, state.displacements, positions);
    std::vector<Sphere> leaves(tissue_.leaves.anchors.size());
    moveLeaves(tissue_, state.displacements, positions, leaves);
    figures.fault = findFault(movedTree(tree_, leaves));
    for (const Sphere& leaf : leaves) figures.largest_radius_mm = std::max(figures.largest_radius_mm, static_cast<double>(leaf.radius));
    figures.bare_samples = bareSamples(leaves, positions);
    if (figures.strain.inverted == 0) figures.overhang_mm = overhang(leaves, positions);
    return figures;
  }

  // Independent of the pieces: a sample may lie in any leaf. Includes a margin for the rounding of the sample itself.
  std::size_t bareSamples(const std::vector<Sphere>& leaves, const std::vector<Vector3d>& positions) const {
    std::vector<Ball> balls;
    for (const Sphere& s : leaves) balls.push_back({centreOf(s), s.radius});
    const BallIndex index(balls);
    std::size_t bare = 0;
    for (const Sample& sample : samples_) {
      const Triangle& vertex = surface_.triangles[sample.triangle];
      const Vector3d p =
          sample.weight[0] * positions[vertex[0]] + sample.weight[1] * positions[vertex[1]] + sample.weight[2] * positions[vertex[2]];
      bool is_held = false;
      index.tree.searchWithin(p, 0, [&](std::size_t first, std::size_t count) {
        for (std::size_t slot = first; !is_held && slot < first + count; ++slot)
          is_held = (p - index.balls[slot].centre).squaredNorm() <= index.balls[slot].radius * index.balls[slot].radius;
      });
      bare += !is_held;
    }
    return bare;
  }

  double overhang(const std::vector<Sphere>& leaves, const std::vector<Vector3d>& positions) const {
    TriangleMesh moved = mesh_;
    std::copy_n(positions.begin(), moved.positions.size(), moved.positions.begin());
    const DistanceField field(moved);
    double largest = 0;
    for (const Sphere& leaf : leaves) largest = std::max(largest, overhangBound(field, Vector3d::Zero(), leaf));
    return largest;
  }

 private:
  const TriangleMesh& mesh_;
  const TriangleMesh& surface_;
  const SphereTree& tree_;
  const Tissue& tissue_;
  std::vector<Sample> samples_;
};

}  // namespace

StatesEvaluation evaluateStates(const TriangleMesh& mesh, const TriangleMesh& surface, const SphereTree& tree, const Tissue& tissue,
                                std::size_t count, const std::function<TissueState(std::size_t)>& state, std::size_t samples,
                                std::uint64_t seed, Progress& progress) {
  const Evaluator evaluator(mesh, surface, tree, tissue, samples, seed);
  StatesEvaluation out{tissue.leaves.anchors.size(), samples, 0, std::vector<StateFigures>(count)};
  const TissueState rest{"rest", 0, std::vector<Vector3d>(tissue.nodes.size(), Vector3d::Zero())};
  out.rest_overhang_mm = evaluator.of(rest).overhang_mm.value_or(0);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    progress.check();
    out.states[i] = evaluator.of(state(i));
  });
  progress.advance(1);
  return out;
}

}  // namespace spheretree::builder

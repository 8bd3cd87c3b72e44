// SPDX-License-Identifier: GPL-3.0-or-later
// The search for pairs of a tool and deformed tissue, against brute force. Subject: SoftTissue::keepNear()
#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cstdlib>
#include <vector>

#include "search/find_pairs.h"
#include "spheretree/runtime/step.h"
#include "state/step_memory.h"
#include "support/random.h"
#include "support/shape_trees.h"
#include "support/soft_block.h"
#include "support/triangle_distance.h"
#include "tissue/moved_skin.h"
#include "tissue/soft_model.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;

/// Displacements of the pressed nodes: a rotation, stretches and noise, of up to some millimetres.
std::vector<float> randomState(const SoftModel& model, test::Random& random) {
  Eigen::Matrix3d map;
  for (double& x : map.reshaped()) x = random.between(-0.15, 0.15);
  const double noise = random.between(0, 0.4);
  std::vector<float> state;
  for (std::size_t i = 0; i < model.node_count; ++i) {
    const Vector3d u = map * model.node_places[i].cast<double>() + test::randomPoint(random, noise);
    for (const double x : u) state.push_back(static_cast<float>(x));
  }
  return state;
}

/// The number of pairs of a leaf and a triangle of `slots` within `margin`; each has to be among `pairs`.
std::size_t nearAndFound(const CompiledScene& scene, const MovedSkin& truth, const CompiledShape& shape, const Configuration& pose,
                         double margin, const std::vector<std::uint32_t>& slots, const std::vector<std::uint32_t>& pairs) {
  std::size_t near = 0;
  for (std::uint32_t leaf = 0; leaf < scene.tool.spheres.size(); ++leaf) {
    const Sphere& ball = scene.tool.spheres[leaf];
    if (scene.tool.isInner(leaf) || scene.tool.item[leaf] == kNoItem) continue;
    const Vector3d centre = pose.orientation * Vector3d(ball.x, ball.y, ball.z) + pose.position - shape.centre;
    for (const std::uint32_t slot : slots) {
      const auto& p = truth.patches()[shape.skin.tree.item[slot]].position;
      const auto corner = [&](int c) { return Vector3d(p[c][0], p[c][1], p[c][2]); };
      const double gap = test::distanceToTriangle(centre, {corner(0), corner(1), corner(2)}) - static_cast<double>(ball.radius);
      if (gap > margin) continue;
      ++near;
      EXPECT_TRUE(std::binary_search(pairs.begin(), pairs.end(), leaf << 16 | slot));
    }
  }
  return near;
}

// The triangles that a search finds were last updated in other states.
TEST(TissuePairs, NoneIsMissedInAnyState) {
  const bool is_long = std::getenv("SPHERETREE_LONG") != nullptr;
  const int states = is_long ? 2000 : 20, poses = 50;  // with SPHERETREE_LONG=1: 10^5 poses
  const test::SoftBlock& block = test::fineBlock();
  SceneDescription d;
  d.tool = test::ellipsoidTree({4, 2, 1.5}, 64, 0.5);
  d.objects.push_back({});
  d.objects[0].tree = block.shared;
  d.objects[0].tissue = block.model;
  Scene scene;
  std::string fault;
  ASSERT_TRUE(compileScene(d, scene, fault)) << fault;
  Workspace workspace(scene);
  StepMemory& memory = workspace.memory();
  const CompiledShape& shape = memory.scene.shapeOf(0);
  const auto& model = static_cast<const SoftModel&>(*shape.tissue);
  std::vector<std::uint32_t> all;
  for (std::uint32_t slot = 0; slot < shape.skin.tree.item.size(); ++slot)
    if (shape.skin.tree.item[slot] != kNoItem) all.push_back(slot);
  test::Random random(11);
  std::size_t found = 0, near = 0;
  const auto stay = [&](int steps) {
    for (int i = 0; i < steps; ++i) step(scene, {{0, 0, 200}, {1, 0, 0, 0}}, Mode::Constrained, workspace);
  };
  stay(1);
  for (int n = 0; n < states; ++n) {
    const std::vector<float> state = randomState(model, random);
    ASSERT_TRUE(aimTissue(0, state, false, workspace));
    stay(400);
    MovedSkin truth(model, shape);
    truth.bend(state);
    truth.put(all, state);
    for (int k = 0; k < poses; ++k) {
      const std::uint32_t at = all[random.below(static_cast<std::uint32_t>(all.size()))];
      const auto& place = truth.patches()[shape.skin.tree.item[at]].position[0];
      const Configuration pose{Vector3d(place[0], place[1], place[2]) + shape.centre + test::randomPoint(random, 3),
                               test::randomRotation(random)};
      const double margin = random.between(0, 1);
      PairSet set = findPairs(pose, margin, PairsOf::ContactSurface, 1u << 30, memory);
      ASSERT_FALSE(set.coarse);
      memory.tissue->keepNear(pose, margin, set);
      std::vector<std::uint32_t> pairs(set.pairs.begin(), set.pairs.end());
      std::sort(pairs.begin(), pairs.end());
      found += pairs.size();
      near += nearAndFound(scene.compiled(), truth, shape, pose, margin, all, pairs);
      ASSERT_FALSE(HasFailure()) << "state " << n << ", pose " << k;
    }
  }
  EXPECT_GT(near, 100u * static_cast<std::size_t>(states));
  EXPECT_LT(found, 4 * near) << "it also leaves out most of what is farther away";
}

}  // namespace
}  // namespace spheretree::runtime

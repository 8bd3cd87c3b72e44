// SPDX-License-Identifier: GPL-3.0-or-later
#include "upper_levels.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

#include "spheretree/builder/build_sphere_tree.h"
#include "support/dense_points.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

SphereTree builtTree(const TriangleMesh& mesh, double tolerance) {
  BuildSettings settings;
  settings.quality = Quality::Quick;
  settings.tolerance_mm = tolerance;
  Progress progress;
  return buildSphereTree(mesh, settings, progress).tree;
}

std::vector<Sphere> levelSpheres(const SphereTree& tree, int level) {
  std::vector<Sphere> out;
  for (const std::uint32_t node : levelSet(tree, level)) out.push_back(tree.cover[node]);
  return out;
}

TEST(UpperLevels, AreSoundTreesWhoseLeavesAreTheLevel) {
  const TriangleMesh mesh = test::joined(test::moved(test::sphereMesh(2, 4), {0, 0, 9}), test::torusMesh(5, 1, 32, 12));
  for (const double tolerance : {0.0, 0.05}) {  // full levels; leaves on several levels
    const SphereTree tree = builtTree(mesh, tolerance);
    ASSERT_EQ(tree.levelCount(), 4);
    for (int levels = kMinLevels; levels <= tree.levelCount(); ++levels) {
      SCOPED_TRACE(testing::Message() << levels << " levels, tolerance " << tolerance);
      const SphereTree upper = upperLevels(tree, levels);
      EXPECT_EQ(findFault(upper), "");
      EXPECT_EQ(upper.levelCount(), levels);
      EXPECT_EQ(upper.skin, tree.skin);
      for (int level = 0; level < levels; ++level) {
        EXPECT_EQ(levelSpheres(upper, level), levelSpheres(tree, level));
        EXPECT_EQ(upper.statistics[static_cast<std::size_t>(level)], tree.statistics[static_cast<std::size_t>(level)]);
      }
      // No bounding sphere is larger than that of the whole tree, below which there is more.
      for (std::size_t node = 0; node < upper.nodeCount(); ++node)
        EXPECT_LE(sphereOf(upper, node, SphereKind::Bound).radius, 1.0001F * sphereOf(tree, node, SphereKind::Bound).radius);
    }
    EXPECT_EQ(upperLevels(tree, tree.levelCount()), tree);
  }
}

TEST(UpperLevels, RefusesLevelsThatTheTreeDoesNotHave) {
  const SphereTree tree = builtTree(test::sphereMesh(2, 2), 0);
  EXPECT_THROW(upperLevels(tree, kMinLevels - 1), std::invalid_argument);
  EXPECT_THROW(upperLevels(tree, tree.levelCount() + 1), std::invalid_argument);
}

}  // namespace
}  // namespace spheretree::builder

// SPDX-License-Identifier: Apache-2.0
#include "spheretree/runtime/scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "scene/compiled_scene.h"
#include "support/sample_skins.h"
#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

using test::Random;

SceneDescription sound() {
  SceneDescription d;
  d.tool = test::randomTree(1, 4, 8);
  d.tool.origin_mm = {1, 2, 3};
  d.reference_point = {4, 5, 6};
  Random random(2);
  for (int i = 0; i < 3; ++i)
    d.objects.push_back({test::randomTree(random.next(), 5, 6), {test::randomPoint(random, 50), test::randomRotation(random)}});
  return d;
}

TEST(Scene, EveryLeafHasOneSlotAndStandsWhereItShould) {
  const SceneDescription d = sound();
  Scene scene;
  std::string fault;
  ASSERT_TRUE(compileScene(d, scene, fault)) << fault;
  const auto check = [](const SphereTree& tree, const CompiledTree& compiled, const std::vector<std::uint32_t>& nodes,
                        const std::function<Eigen::Vector3d(Eigen::Vector3d)>& place) {
    std::vector<int> seen(tree.nodeCount(), 0);
    std::vector<int> met(compiled.item.size(), 0);  // (slot) by its parent
    double reach = 0;
    for (std::size_t slot = 0; slot < compiled.item.size(); ++slot) {
      const std::uint32_t item = compiled.item[slot];
      const Block& block = compiled.bound[slot / 8];
      const Sphere& record = compiled.spheres[slot];
      EXPECT_EQ(block.x[slot % 8], record.x);
      EXPECT_EQ(block.r[slot % 8], record.radius);
      if (compiled.isInner(slot)) {
        EXPECT_EQ(item, kNoItem);
        const std::size_t first = 8 * (std::size_t{compiled.links[slot / 8].first_child} + slot % 8);
        for (std::size_t child = first; child < first + 8; ++child) ++met.at(child);
        continue;
      }
      if (item == kNoItem) {
        EXPECT_GT(block.x[slot % 8], 1e17f);
        EXPECT_EQ(block.r[slot % 8], 0);
        continue;
      }
      const std::uint32_t node = nodes.at(item);
      ++seen[node];
      EXPECT_TRUE(tree.isLeaf(node));
      const Sphere& leaf = tree.cover[node];
      const Eigen::Vector3d c =
          place(Eigen::Vector3d(leaf.x, leaf.y, leaf.z) + Eigen::Vector3d(tree.origin_mm[0], tree.origin_mm[1], tree.origin_mm[2]));
      EXPECT_LT((Eigen::Vector3d(record.x, record.y, record.z) - c).norm(), 1e-5);
      EXPECT_EQ(record.radius, leaf.radius);
      EXPECT_LT((Eigen::Vector3d(compiled.exact[slot][0], compiled.exact[slot][1], compiled.exact[slot][2]) - c).norm(), 1e-12);
      reach = std::max(reach, c.norm() + static_cast<double>(leaf.radius));
    }
    for (std::size_t n = 0; n < seen.size(); ++n) EXPECT_EQ(seen[n], tree.isLeaf(n) ? 1 : 0) << "node " << n;
    for (std::size_t slot = 8; slot < met.size(); ++slot) EXPECT_EQ(met[slot], 1) << "slot " << slot;
    EXPECT_NEAR(compiled.reach, reach, 1e-9);
  };
  const CompiledScene& compiled = scene.compiled();
  check(d.tool, compiled.tool, compiled.tool_nodes, [&](const Eigen::Vector3d& c) -> Eigen::Vector3d { return c - d.reference_point; });
  for (std::size_t i = 0; i < d.objects.size(); ++i)
    check(*d.objects[i].tree, compiled.shapeOf(i).leaves, compiled.shapeOf(i).nodes, [&](const Eigen::Vector3d& c) -> Eigen::Vector3d {
      const CompiledObject& object = compiled.objects[i];
      EXPECT_LT((object.rotation - d.objects[i].pose.orientation.toRotationMatrix()).norm(), 1e-12);
      return object.rotation.transpose() * (d.objects[i].pose.orientation * c + d.objects[i].pose.position - object.anchor);
    });
  EXPECT_DOUBLE_EQ(compiled.angle_length, std::sqrt(1000));
}

TEST(Scene, RefusesWithTheReason) {
  const auto refuse = [](const char* part, const std::function<void(SceneDescription&)>& spoil) {
    SceneDescription d = sound();
    spoil(d);
    Scene scene;
    std::string fault;
    EXPECT_FALSE(compileScene(d, scene, fault)) << part;
    EXPECT_NE(fault.find(part), std::string::npos) << fault;
    EXPECT_EQ(scene.objectCount(), 0u);  // unchanged
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  refuse("translation stiffness", [](auto& d) { d.coupling.translation = 0; });
  refuse("rotation stiffness", [&](auto& d) { d.coupling.rotation = nan; });
  refuse("force limit", [](auto& d) { d.wrench_limits.force = -1; });
  refuse("torque limit", [](auto& d) { d.wrench_limits.torque[1] = 0; });
  refuse("max_pairs", [](auto& d) { d.step_limits.max_pairs = 191; });
  refuse("max_pairs", [](auto& d) { d.step_limits.max_pairs = (1 << 20) + 1; });
  refuse("max_work", [](auto& d) { d.step_limits.max_work = 999; });
  refuse("tool: ", [](auto& d) { d.tool = {}; });
  refuse("tool: ", [](auto& d) { d.tool.bound[0].radius *= 0.5f; });
  refuse("tool: ", [&](auto& d) { d.reference_point[0] = nan; });
  refuse("tool: ", [&](auto& d) { d.reference_point[0] = 1e9; });
  refuse("object 1: ", [](auto& d) {
    SphereTree tree = *d.objects[1].tree;
    tree.cover[0].x += 1000;
    d.objects[1].tree = std::move(tree);
  });
  refuse("object 2: ", [&](auto& d) { d.objects[2].pose.position[1] = nan; });
  refuse("object 2: ", [](auto& d) { d.objects[2].pose.orientation = Quaternion(0, 0, 0, 0); });
  refuse("object 0: ", [](auto& d) { d.objects[0].pose.position[1] = 1e8; });
}

TEST(Scene, ManyObjectsNeedMorePairs) {
  EXPECT_EQ(defaultLimits(3).max_pairs, StepLimits().max_pairs);
  SceneDescription d = sound();
  d.objects.resize(200, d.objects[0]);
  Scene scene;
  std::string fault;
  EXPECT_FALSE(compileScene(d, scene, fault));
  EXPECT_EQ(fault, "max_pairs is 8192; it must be 64 for each object .. 1048576");
  d.step_limits = defaultLimits(d.objects.size());
  EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
}

TEST(Scene, CopiesAreCompiledOnce) {
  SceneDescription d;
  d.tool = test::oneBallTree(1);
  const SharedTree shared(test::withSkin(test::ellipsoidTree({5, 5, 5}, 400, 1), test::roundSkin(4)));
  const auto bytesOf = [&](std::size_t count) {
    d.objects.resize(count, {shared, {{1, 2, 3}, Quaternion(1, 0, 0, 0)}});
    d.step_limits = defaultLimits(count);
    Scene scene;
    std::string fault;
    EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
    EXPECT_EQ(scene.objectCount(), count);
    EXPECT_EQ(scene.compiled().shapes.size(), 1u);
    return scene.byteCount();
  };
  const std::size_t one = bytesOf(1), thousand = bytesOf(1000);
  EXPECT_GT(one, 2048 * sizeof(CompiledPatch));
  EXPECT_LT(thousand - one, 999u * 200u);
  // Two trees with equal content are two trees.
  d.objects = {{*shared, {}}, {*shared, {}}, {shared, {}}, {shared, {}}};
  Scene scene;
  std::string fault;
  ASSERT_TRUE(compileScene(d, scene, fault)) << fault;
  EXPECT_EQ(scene.compiled().shapes.size(), 3u);
}

TEST(Scene, CompilesASkinTriangleByTriangle) {
  SphereTree tree = test::withSkin(test::ellipsoidTree({5, 5, 5}, 100, 1), test::randomSkin(5));
  tree.origin_mm = {100, -50, 25};
  SceneDescription d;
  d.tool = test::oneBallTree(1);
  d.objects.push_back({tree, {{1, 2, 3}, rotationOf({0.5, 0.2, -0.8})}});
  Scene scene;
  std::string fault;
  ASSERT_TRUE(compileScene(d, scene, fault)) << fault;
  const CompiledShape& body = scene.compiled().shapeOf(0);
  const CompiledObject& object = scene.compiled().objects[0];
  ASSERT_EQ(body.skin.patch.size(), tree.skin.triangles.size());
  EXPECT_EQ(body.skin.tolerance, tree.skin.tolerance);
  std::vector<int> seen(body.skin.patch.size(), 0);
  for (std::size_t slot = 0; slot < body.skin.tree.item.size(); ++slot) {
    const std::uint32_t t = body.skin.tree.item[slot];
    if (t == kNoItem) continue;
    ++seen.at(t);
    const SkinPatch expected = patchOf(tree.skin, t);
    const CompiledPatch& patch = body.skin.patch[t];
    const Block& bound = body.skin.tree.bound[slot / 8];
    const std::size_t lane = slot % 8;
    for (std::size_t i = 0; i < 6; ++i) {
      const Eigen::Vector3d p(patch.position[i][0], patch.position[i][1], patch.position[i][2]);
      const Eigen::Vector3d world = d.objects[0].pose.orientation * (expected.position[i].cast<double>() + Eigen::Vector3d(100, -50, 25)) +
                                    d.objects[0].pose.position;
      EXPECT_LT((object.rotation * p + object.anchor - world).norm(), 1e-4);
      EXPECT_LE((p - Eigen::Vector3d(bound.x[lane], bound.y[lane], bound.z[lane])).norm(), static_cast<double>(bound.r[lane]) + 1e-4);
      EXPECT_LE(p.norm(), body.radius + 1e-4);
      for (std::size_t axis = 0; axis < 3; ++axis)
        EXPECT_NEAR(static_cast<std::int16_t>(patch.normal[i][axis]) / 32767.0,
                    static_cast<double>(expected.normal[i][static_cast<Eigen::Index>(axis)]), 4e-5);
    }
    for (std::uint32_t k = 0; k < 3; ++k) EXPECT_EQ((patch.flags >> k & 1) != 0, expected.is_sharp[k]);
    EXPECT_EQ((patch.flags & kCurved) != 0, allowanceOf(expected, tree.skin.tolerance) > 0);
  }
  for (const int count : seen) EXPECT_EQ(count, 1);
  d.contact = ContactSurface::Leaves;
  ASSERT_TRUE(compileScene(d, scene, fault)) << fault;
  EXPECT_TRUE(scene.compiled().shapeOf(0).skin.empty());
}

TEST(Scene, RefusesAnUnsoundSkin) {
  SceneDescription d = sound();
  SphereTree tree = test::withSkin(*d.objects[1].tree, test::roundSkin(1));
  tree.skin.triangles[3].vertex[1] = 60000;
  d.objects[1].tree = std::move(tree);
  Scene scene;
  std::string fault;
  EXPECT_FALSE(compileScene(d, scene, fault));
  EXPECT_EQ(fault.rfind("object 1: ", 0), 0u) << fault;
  EXPECT_NE(fault.find("triangle 3"), std::string::npos) << fault;
}

TEST(Scene, AnEmptyWorldIsFine) {
  SceneDescription d = sound();
  d.objects.clear();
  Scene scene;
  std::string fault;
  EXPECT_TRUE(compileScene(d, scene, fault)) << fault;
}

}  // namespace
}  // namespace spheretree::runtime

// SPDX-License-Identifier: Apache-2.0
// The contacts that a step reports. Subject: contacts() of step.h
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "spheretree/runtime/step.h"
#include "support/compiled_scene.h"
#include "support/rig.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using test::compiled;
using test::kUpright;
using test::Random;

// Force and torque on the graphic tool, about its reference point.
Wrench sumOf(std::span<const Contact> contacts, const Vector3d& about) {
  Wrench sum;
  for (const Contact& c : contacts) {
    sum.force += c.force * c.normal;
    sum.torque += (c.point - about).cross(c.force * c.normal);
  }
  return sum;
}

TEST(Contacts, BalanceTheSpring) {
  for (const ContactSurface surface : {ContactSurface::Skin, ContactSurface::Leaves}) {
    SceneDescription d;
    d.tool = test::rodTree(12, 30, 0.4);
    d.reference_point = {0, 0, 4};
    d.contact = surface;
    const SphereTree body = test::withSkin(test::ellipsoidTree({6.5, 6.5, 6.5}, 600, 1.5), test::cuspedSkin(4));
    d.objects.push_back({body, {}});
    d.objects.push_back({body, {{13.5, 1, 0}, rotationOf({0.4, 1, 0.2})}});
    const Scene scene = compiled(d);
    Workspace workspace(scene);
    Random random(1);
    int held = 0, many = 0, on_second = 0;
    for (int n = 0; n < 150; ++n) {
      // Down onto either object, or into the valley between them, and at rest there.
      Vector3d way = random.direction(), target = 5 * way;
      if (n % 3 == 1) target += Vector3d(13.5, 1, 0);
      if (n % 3 == 2) {
        way.x() = 0;
        way.normalize();
        target = Vector3d(6.75, 0.5, 0) + random.between(2, 4) * way;
      }
      const Quaternion turn = test::randomRotation(random);
      resetTo({target + 25 * way, turn}, workspace);
      for (int k = 0; k < 50; ++k) step(scene, {target + (25 - 0.5 * (k + 1)) * way, turn}, Mode::Constrained, workspace);
      StepResult r, last;
      for (int k = 0; k < 400; ++k) {
        last = r;
        r = step(scene, {target, turn}, Mode::Constrained, workspace);
        if (k > 0 && (r.wrench.force - last.wrench.force).norm() < 1e-7) break;
      }
      const std::span<const Contact> now = contacts(workspace);
      ASSERT_LE(now.size(), kMaxContacts);
      for (const Contact& c : now) {
        ASSERT_LT(c.object, 2u);
        ASSERT_NEAR(c.normal.norm(), 1, 1e-5);
        ASSERT_GT(c.force, 0);
        ASSERT_EQ(c.on_skin, surface == ContactSurface::Skin);
        ASSERT_TRUE(d.tool.isLeaf(c.tool_leaf));
        // The point is on the ball of the tool's leaf, on the side of the object.
        const Sphere& ball = d.tool.cover[c.tool_leaf];
        const Vector3d centre = r.graphic.orientation * (Vector3d(ball.x, ball.y, ball.z) - d.reference_point) + r.graphic.position;
        ASSERT_LT((c.point + static_cast<double>(ball.radius) * c.normal - centre).norm(), 1e-4);
        on_second += c.object == 1;
      }
      const Wrench sum = sumOf(now, r.graphic.position);
      EXPECT_LT((sum.force - r.wrench.force).norm(), 1e-3) << n << ", " << now.size() << " contacts, faults " << r.faults;
      EXPECT_LT((sum.torque - r.wrench.torque).norm(), 0.05) << n << ", " << now.size() << " contacts";
      held += !now.empty();
      many += now.size() > 1;
    }
    EXPECT_GT(held, 100);
    EXPECT_GT(many, 30);
    EXPECT_GT(on_second, 40);
  }
}

TEST(Contacts, LieOnTheSkinAndNameIt) {
  const Configuration at{{4, -3, 8}, rotationOf({0.7, 0.3, -1})};
  SceneDescription d;
  d.tool = test::oneBallTree(1);
  const Skin skin = test::roundSkin(4);
  d.objects.push_back({test::oneBallTree(1), {{-50, 0, 0}, kUpright}});
  d.objects.push_back({test::withSkin(test::oneBallTree(5.2), skin), at});
  const Scene scene = compiled(d);
  Workspace workspace(scene);
  Random random(2);
  for (int n = 0; n < 100; ++n) {
    const Vector3d way = random.direction();
    resetTo({at.position + 6.3 * way, kUpright}, workspace);
    for (int k = 0; k < 20; ++k) step(scene, {at.position + 5.5 * way, kUpright}, Mode::Constrained, workspace);
    const std::span<const Contact> held = contacts(workspace);
    ASSERT_EQ(held.size(), 1u) << way.transpose();
    const Contact& c = held[0];
    EXPECT_EQ(c.object, 1u);
    EXPECT_TRUE(c.on_skin);
    EXPECT_LT((c.point - (at.position + 5 * way)).norm(), 2e-3);
    EXPECT_LT((c.normal - way).norm(), 2e-3);
    EXPECT_NEAR(c.force, 0.5, 2e-3);
    ASSERT_LT(c.element, skin.triangles.size());
    const SkinPatch patch = patchOf(skin, c.element);
    const Vector3d local = at.orientation.conjugate() * (c.point - at.position);
    double nearest = 1e9, longest = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      nearest = std::min(nearest, (patch.position[k].cast<double>() - local).norm());
      longest = std::max(longest, static_cast<double>((patch.position[(k + 1) % 3] - patch.position[k]).norm()));
    }
    EXPECT_LT(nearest, longest);  // the triangle is the one below, or adjacent to it
  }
}

TEST(Contacts, OfLeavesLieOnTheLeaf) {
  SceneDescription d;
  d.tool = test::oneBallTree(2);
  d.objects.push_back({test::treeOfBalls({test::ball(-10, 0, 0, 3), test::ball(10, 0, 0, 3)}), {{0, 0, 5}, kUpright}});
  const Scene scene = compiled(d);
  Workspace workspace(scene);
  step(scene, {{10, 0, 15}, kUpright}, Mode::Constrained, workspace);
  EXPECT_TRUE(contacts(workspace).empty());
  for (int k = 0; k < 10; ++k) step(scene, {{10, 0, 9}, kUpright}, Mode::Constrained, workspace);
  ASSERT_EQ(contacts(workspace).size(), 1u);
  const Contact& c = contacts(workspace)[0];
  EXPECT_FALSE(c.on_skin);
  EXPECT_LT((c.point - Vector3d(10, 0, 8)).norm(), 1e-3);
  EXPECT_NEAR(c.force, 1, 1e-3);
  EXPECT_EQ(d.objects[0].tree->cover[c.element].x, 10);
}

TEST(Contacts, AreAbsentInFreeSpace) {
  SceneDescription d;
  d.tool = test::oneBallTree(1);
  d.objects.push_back({test::withSkin(test::oneBallTree(5.2), test::roundSkin(3)), {}});
  const Scene scene = compiled(d);
  Workspace workspace(scene);
  EXPECT_TRUE(contacts(workspace).empty());
  const auto to = [&](double z, Mode mode) { step(scene, {{0, 0, z}, kUpright}, mode, workspace); };
  to(8, Mode::Constrained);
  to(5.5, Mode::Constrained);
  EXPECT_EQ(contacts(workspace).size(), 1u);
  to(5.5, Mode::Published);
  EXPECT_TRUE(contacts(workspace).empty());                 // the published algorithm has no forces of contacts
  for (int n = 0; n < 10; ++n) to(5.5, Mode::Constrained);  // down from the leaf, at the largest rate of the force
  EXPECT_FALSE(contacts(workspace).empty());
  to(8, Mode::Constrained);
  EXPECT_TRUE(contacts(workspace).empty());
  to(5.5, Mode::Constrained);
  reset(workspace);
  EXPECT_TRUE(contacts(workspace).empty());
}

}  // namespace
}  // namespace spheretree::runtime

// SPDX-License-Identifier: Apache-2.0
#include "tissue/soft_surface.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "support/octahedron_tissue.h"
#include "support/random.h"

namespace spheretree::runtime {
namespace {

using Eigen::Vector3d;
using Field = std::vector<float>;

/// The surface of an octahedron of tissue; its node at -z is fixed.
struct SurfaceRig {
  test::OctahedronTissue made = test::octahedronTissue(1.3f, 5);
  std::shared_ptr<SoftModel> model = softModel(made.tree, made.tissue);
  CompiledShape shape;
  std::unique_ptr<SoftSurface> surface;
  test::Random random{7};

  SurfaceRig() {
    shape.centre.setZero();
    shape.skin = compileSkin(made.tree->skin, Vector3d::Zero());
    shape.radius = 6;
    surface = std::make_unique<SoftSurface>(*model, shape);
    begin();
  }
  void begin(double share = 0, double max_motion = 1, double motion = 1e9) { surface->beginStep(share, max_motion, motion); }
  SkinPoint randomPoint() {
    const double u = random.unit(), v = (1 - u) * random.unit();
    return {static_cast<std::uint32_t>(random.below(made.tree->skin.triangles.size())), {u, v, 1 - u - v}};
  }
  /// The weighted mean of a field of the pressed nodes, by the definition.
  Vector3d meanOf(const SkinPoint& point, const Field& field) const {
    Vector3d sum = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      const PressPoint& corner = model->vertices[made.tree->skin.triangles[point.triangle].vertex[k]].point;
      for (std::size_t i = 0; i < 3; ++i)
        if (corner.node[i] != kNone)
          sum += point.weight[k] * static_cast<double>(corner.weight[i]) *
                 Eigen::Map<const Eigen::Vector3f>(field.data() + 3 * corner.node[i]).cast<double>();
    }
    return sum;
  }
  /// Displacements of the pressed nodes under the current forces: the compliance times the forces.
  Field compliant() const {
    const std::span<const float> forces = surface->forces();
    Field out(forces.size(), 0.0f);
    for (std::size_t i = 0; i < forces.size(); ++i)
      for (std::size_t k = 0; k < out.size(); ++k) out[k] += forces[i] * model->column(i)[k];
    return out;
  }
  /// Sets the target forces of a piece to some on random points.
  void pressSomewhere(int count) {
    surface->aimAt(false);
    for (int i = 0; i < count; ++i) surface->press(surface->response().pressOn(randomPoint()), random.inCube(1));
  }
  void expectSame(const SkinPoint& point, const Vector3d& is, const Field& field) const {
    EXPECT_LT((is - meanOf(point, field)).norm(), 1e-5) << "triangle " << point.triangle;
  }
};

TEST(SoftSurface, AtRestNothingIsDisplaced) {
  SurfaceRig rig;
  EXPECT_TRUE(rig.surface->isAtRest());
  for (int n = 0; n < 20; ++n) {
    const SkinPoint point = rig.randomPoint();
    EXPECT_EQ(rig.surface->given(point), Vector3d::Zero());
    EXPECT_EQ(rig.surface->travelled(point), Vector3d::Zero());
    EXPECT_EQ(rig.surface->ahead(point), Vector3d::Zero());
  }
}

TEST(SoftSurface, YieldsByItsComplianceUnderTheForces) {
  SurfaceRig rig;
  for (int round = 0; round < 10; ++round) {
    rig.pressSomewhere(1 + round % 3);
    rig.surface->giveWay(1);
    EXPECT_FALSE(rig.surface->isAtRest());
    for (int n = 0; n < 20; ++n) {
      const SkinPoint point = rig.randomPoint();
      rig.expectSame(point, rig.surface->given(point), rig.compliant());
      rig.expectSame(point, rig.surface->travelled(point), rig.compliant());
    }
  }
  rig.surface->aimAt(false);
  rig.surface->giveWay(1);
  EXPECT_TRUE(rig.surface->isAtRest()) << "without forces it is back";
}

TEST(SoftSurface, AForceOnAPointGoesToItsNodesByTheirWeights) {
  SurfaceRig rig;
  bool some_are_held = false;
  for (int n = 0; n < 100; ++n) {
    const SkinPoint point = rig.randomPoint();
    const SurfaceResponse::Press press = rig.surface->response().pressOn(point);
    Field weights(15, 0.0f);
    for (std::size_t p = 0; p < press.count; ++p) {
      EXPECT_EQ(weights[3 * press.node[p]], 0) << "each node once";
      weights[3 * press.node[p]] = static_cast<float>(press.weight[p]);
    }
    double sum = 0;
    for (std::uint32_t node = 0; node < 5; ++node) {
      Field unit(15, 0.0f);
      unit[3 * node] = 1;
      EXPECT_NEAR(weights[3 * node], rig.meanOf(point, unit).x(), 1e-6) << "as the node moves the point";
      sum += static_cast<double>(weights[3 * node]);
    }
    EXPECT_LT(sum, 1 + 1e-6);
    some_are_held = some_are_held || sum < 0.9;
  }
  EXPECT_TRUE(some_are_held) << "the share of the fixed node is left out";
}

TEST(SoftSurface, GivesWayByTheShareAndFromTheForcesOfBefore) {
  SurfaceRig rig;
  rig.pressSomewhere(2);
  rig.surface->giveWay(1);
  const Field before(rig.surface->forces().begin(), rig.surface->forces().end());
  rig.surface->aimAt(true);
  const SurfaceResponse::Press press = rig.surface->response().pressOn(rig.randomPoint());
  rig.surface->press(press, {0.5, -1, 2});
  rig.surface->giveWay(1);
  Field whole = before;
  for (std::size_t p = 0; p < press.count; ++p)
    for (std::size_t axis = 0; axis < 3; ++axis)
      whole[3 * press.node[p] + axis] += static_cast<float>(press.weight[p] * Vector3d(0.5, -1, 2)[static_cast<Eigen::Index>(axis)]);
  for (std::size_t i = 0; i < whole.size(); ++i) EXPECT_NEAR(rig.surface->forces()[i], whole[i], 1e-6) << "the new force is added";
  for (const double share : {0.25, 0.0, 0.75}) {
    rig.surface->giveWay(share);
    for (std::size_t i = 0; i < whole.size(); ++i)
      EXPECT_NEAR(rig.surface->forces()[i], (1 - share) * static_cast<double>(before[i]) + share * static_cast<double>(whole[i]), 1e-6);
    const SkinPoint point = rig.randomPoint();
    rig.expectSame(point, rig.surface->given(point), rig.compliant());
  }
}

TEST(SoftSurface, ForcesMoveNoNodeFartherThanTheStepAllows) {
  SurfaceRig rig;
  rig.pressSomewhere(2);
  rig.surface->giveWay(1);
  const Field start = rig.compliant();
  rig.begin(0, 1, 0.25);
  EXPECT_EQ(rig.surface->motionSoFar(), 0);
  rig.pressSomewhere(3);
  rig.surface->giveWay(1);
  double largest = 0;
  for (std::size_t i = 0; i < 15; i += 3)
    largest =
        std::max(largest, (Eigen::Map<const Eigen::Vector3f>(rig.compliant().data() + i) - Eigen::Map<const Eigen::Vector3f>(&start[i]))
                              .cast<double>()
                              .norm());
  EXPECT_NEAR(largest, 0.25, 1e-5) << "the tissue waits";
  EXPECT_NEAR(rig.surface->motionSoFar(), 0.25, 1e-12);
  const SkinPoint point = rig.randomPoint();
  Field moved = rig.compliant();
  for (std::size_t i = 0; i < 15; ++i) moved[i] -= start[i];
  rig.expectSame(point, rig.surface->movedInStep(point), moved);
}

TEST(SoftSurface, PredictsWhatItWillGiveWithoutMoving) {
  SurfaceRig rig;
  for (int round = 0; round < 10; ++round) {
    SurfaceRig moved;
    const SkinPoint pressed = rig.randomPoint(), other = rig.randomPoint();
    const Vector3d force = rig.random.inCube(1);
    moved.surface->press(moved.surface->response().pressOn(pressed), force);
    moved.surface->giveWay(1);
    rig.surface->response().forgetNear();
    EXPECT_EQ(rig.surface->response().nearCount(), 0u);
    for (const std::uint32_t t : {pressed.triangle, other.triangle, pressed.triangle}) rig.surface->response().addNear(t);
    std::vector<Eigen::Matrix3d> response(rig.surface->response().nearCount());
    rig.surface->response().respond(rig.surface->response().pressOn(pressed), response);
    std::vector<double> near;
    for (const Eigen::Matrix3d& m : response)
      for (const double x : Vector3d(m * force)) near.push_back(x);
    rig.surface->response().predict(near);
    for (const SkinPoint& point : {pressed, other}) {
      EXPECT_LT((rig.surface->response().predicted(point) - moved.surface->given(point)).norm(), 1e-5);
      EXPECT_LT((rig.surface->response().meanOf(rig.surface->response().pressOn(point), near) - moved.surface->given(point)).norm(), 1e-5);
    }
    EXPECT_TRUE(rig.surface->isAtRest());
  }
}

TEST(SoftSurface, TheBaseCoversTheShareOfItsWayUpToALargestMotion) {
  SurfaceRig rig;
  Field aim(15);
  for (float& x : aim) x = static_cast<float>(rig.random.between(-1, 1));
  double longest = 0;
  for (std::size_t i = 0; i < 15; i += 3) longest = std::max(longest, Eigen::Map<Eigen::Vector3f>(&aim[i]).cast<double>().norm());
  const SkinPoint point = rig.randomPoint();
  const auto expectShare = [&](double share) {
    EXPECT_LT((rig.surface->travelled(point) - share * rig.meanOf(point, aim)).norm(), 1e-5) << share;
    EXPECT_EQ(rig.surface->given(point), Vector3d::Zero()) << "no force";
  };
  rig.surface->aim(aim);
  expectShare(0);
  rig.begin(0.25, 10);
  expectShare(0.25);
  EXPECT_LT((rig.surface->ahead(point) - 0.25 * rig.meanOf(point, aim)).norm(), 1e-5) << "the tool has not followed yet";
  EXPECT_LT((rig.surface->movedInStep(point) - 0.25 * rig.meanOf(point, aim)).norm(), 1e-5);
  rig.surface->aimAt(true);
  rig.surface->giveWay(0.5);
  EXPECT_LT((rig.surface->ahead(point) - 0.125 * rig.meanOf(point, aim)).norm(), 1e-5) << "half of it";
  rig.begin(0.5, 0.1);
  expectShare(0.25 + 0.1 / longest);
  rig.begin(1, 10);
  expectShare(1);
  rig.begin(0.5, 10);
  expectShare(1);
  EXPECT_EQ(rig.surface->ahead(point), Vector3d::Zero()) << "it stands";
  rig.surface->reset();
  EXPECT_TRUE(rig.surface->isAtRest());
  rig.begin(1, 10);
  expectShare(0);
}

TEST(SoftSurface, FindsThePointOfATriangleBelowAPoint) {
  SurfaceRig rig;
  for (int n = 0; n < 50; ++n) {
    const SkinPoint wanted = rig.randomPoint();
    const CompiledPatch& patch = rig.shape.skin.patch[wanted.triangle];
    const auto corner = [&](std::size_t k) { return Vector3d(Eigen::Map<const Eigen::Vector3f>(patch.position[k]).cast<double>()); };
    const Vector3d at = wanted.weight[0] * corner(0) + wanted.weight[1] * corner(1) + wanted.weight[2] * corner(2),
                   normal = (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
    const SkinPoint found = rig.surface->skin().pointAt(wanted.triangle, at + rig.random.between(-1, 1) * normal);
    EXPECT_EQ(found.triangle, wanted.triangle);
    for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(found.weight[k], wanted.weight[k], 1e-6);
    double give = 0;
    for (std::size_t k = 0; k < 3; ++k)
      give += found.weight[k] * static_cast<double>(rig.model->vertices[rig.made.tree->skin.triangles[found.triangle].vertex[k]].max_give);
    EXPECT_NEAR(rig.surface->maxGive(found), give, 1e-9);
    const SkinPoint outside =
        rig.surface->skin().pointAt(wanted.triangle, corner(0) + 3 * (corner(0) - corner(1)) + 3 * (corner(0) - corner(2)));
    EXPECT_EQ(outside.weight, (std::array<double, 3>{1, 0, 0})) << "beyond a corner it is the corner";
  }
}

}  // namespace
}  // namespace spheretree::runtime

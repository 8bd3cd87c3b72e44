// SPDX-License-Identifier: Apache-2.0
#include "rows/rows.h"

#include <gtest/gtest.h>

#include <cmath>

#include "search/find_pairs.h"
#include "state/step_memory.h"
#include "support/row_dot.h"
#include "support/shape_trees.h"

namespace spheretree::runtime {
namespace {

using test::Random;
using test::rowDot;

struct RowRig {
  SceneDescription description;
  Scene scene;
  std::unique_ptr<Workspace> workspace;
  explicit RowRig(Kernel kernel = Kernel::Best) {
    description.tool = test::rodTree(20, 40, 1);
    description.reference_point = {1, 2, 12};
    description.objects.push_back({test::boxTree({5, 5, 5}, {5, 5, 5}, 1.5), {{0, 0, -6}, rotationOf({0.3, 0.2, 0.1})}});
    description.objects.push_back({test::ellipsoidTree({4, 4, 6}, 100, 1), {{8, 0, 0}, rotationOf({0, 1, 0})}});
    std::string fault;
    EXPECT_TRUE(compileScene(description, scene, fault)) << fault;
    workspace = std::make_unique<Workspace>(scene, kernel);
  }
  StepMemory& memory() { return workspace->memory(); }
  PairSet pairsAt(const Configuration& pose) { return findPairs(pose, 1, PairsOf::ContactSurface, 1u << 30, memory()); }
  // d(tool leaf, object leaf) and radius sum of pair k, tool at `pose`, in double.
  std::pair<double, double> distance(const PairSet& set, std::uint32_t k, const Configuration& pose) const {
    const PairRun* run = set.runs.data();
    while (k >= run->begin + run->count) ++run;
    const std::uint32_t t = set.pairs[k] >> 16, o = set.pairs[k] & 0xffff;
    const CompiledTree &tool = scene.compiled().tool, &leaves = scene.compiled().shapeOf(run->object).leaves;
    const CompiledObject& object = scene.compiled().objects[run->object];
    const Eigen::Vector3d c(tool.exact[t][0], tool.exact[t][1], tool.exact[t][2]);
    const Eigen::Vector3d b(leaves.exact[o][0], leaves.exact[o][1], leaves.exact[o][2]);
    return {(pose.orientation * c + pose.position - object.rotation * b - object.anchor).norm(),
            static_cast<double>(tool.spheres[t].radius) + static_cast<double>(leaves.spheres[o].radius)};
  }
};

TEST(Rows, RowsAreUnitAndTheGapsAreTrue) {
  RowRig rig;
  Random random(1);
  for (int n = 0; n < 20; ++n) {
    const Configuration pose{test::randomPoint(random, 6), test::randomRotation(random)};
    const PairSet pairs = rig.pairsAt(pose);
    const RowSet set = makeRows(pairs, pose, RowForm::TrueDistance, Eigen::Matrix3d::Identity(), rig.memory());
    ASSERT_EQ(set.rows.count, pairs.pairs.size());
    double smallest = 1e9;
    for (std::uint32_t k = 0; k < set.rows.count; ++k) {
      double square = 0;
      for (const float* a : set.rows.a) square += static_cast<double>(a[k]) * static_cast<double>(a[k]);
      EXPECT_NEAR(square, 1, 1e-6);
      const auto [d, sum] = rig.distance(pairs, k, pose);
      EXPECT_NEAR(static_cast<double>(-set.rows.b[k] / set.weight[k]), d - sum, 1e-5);
      smallest = std::min(smallest, d - sum);
    }
    if (set.rows.count) {
      EXPECT_NEAR(static_cast<double>(set.smallest_gap), smallest, 1e-5);
    }
    for (std::uint32_t k = set.rows.count; k % 8; ++k) EXPECT_LT(set.rows.b[k], -1e29f);  // padding is always satisfied
  }
}

TEST(Rows, RowsAreTheDerivativeOfTheDistance) {
  RowRig rig;
  Random random(2);
  std::uint32_t checked = 0;
  for (int n = 0; n < 20; ++n) {
    const Configuration pose{test::randomPoint(random, 6), test::randomRotation(random)};
    const PairSet pairs = rig.pairsAt(pose);
    const RowSet set = makeRows(pairs, pose, RowForm::TrueDistance, Eigen::Matrix3d::Identity(), rig.memory());
    Displacement step{test::randomPoint(random, 1), test::randomPoint(random, 0.05)};
    Vector6 y;
    y << step.translation, rig.scene.compiled().angle_length * step.rotation;
    const double h = 1e-5;
    const Configuration plus = moved(pose, {h * step.translation, h * step.rotation}),
                        minus = moved(pose, {-h * step.translation, -h * step.rotation});
    for (std::uint32_t k = 0; k < set.rows.count; ++k, ++checked) {
      const double slope = (rig.distance(pairs, k, plus).first - rig.distance(pairs, k, minus).first) / (2 * h);
      EXPECT_NEAR(rowDot(set, k, y), slope, 2e-4);
    }
  }
  EXPECT_GT(checked, 500u);
}

TEST(Rows, SquaredRowsAreThePapersTaylorFormula) {
  RowRig rig;
  Random random(3);
  std::uint32_t checked = 0;
  for (int n = 0; n < 20; ++n) {
    const double gamma = random.between(-3, 3), beta = random.between(-1.4, 1.4), alpha = random.between(-3, 3);
    const auto poseAt = [](const Eigen::Vector3d& x, double g, double b, double a) {
      return Configuration{x, rotationOf({0, 0, a}) * rotationOf({0, b, 0}) * rotationOf({g, 0, 0})};
    };
    const Eigen::Vector3d x = test::randomPoint(random, 6);
    const Configuration pose = poseAt(x, gamma, beta, alpha);
    const PairSet pairs = rig.pairsAt(pose);
    Eigen::Matrix3d axes;
    const Eigen::Matrix3d yaw = rotationOf({0, 0, alpha}).toRotationMatrix(), pitch = rotationOf({0, beta, 0}).toRotationMatrix();
    axes << (yaw * pitch).col(0), yaw.col(1), Eigen::Vector3d::UnitZ();
    const RowSet set = makeRows(pairs, pose, RowForm::SquaredDistance, axes, rig.memory());
    const Eigen::Vector3d dx = test::randomPoint(random, 1), de = test::randomPoint(random, 0.05);
    Vector6 y;
    y << dx, rig.scene.compiled().angle_length * de;
    const double h = 1e-5;
    for (std::uint32_t k = 0; k < set.rows.count; ++k, ++checked) {
      const auto value = [&](double t) {
        const auto [d, sum] = rig.distance(pairs, k, poseAt(x + t * dx, gamma + t * de[0], beta + t * de[1], alpha + t * de[2]));
        return d * d - sum * sum;
      };
      const double d = rig.distance(pairs, k, pose).first;
      EXPECT_NEAR(rowDot(set, k, y) * 2 * d, (value(h) - value(-h)) / (2 * h), 1e-3 * (1 + d));
      EXPECT_NEAR(static_cast<double>(-set.rows.b[k] / set.weight[k]) * 2 * d, value(0), 1e-4 * (1 + d));
    }
  }
  EXPECT_GT(checked, 500u);
}

TEST(Rows, ADistanceRowIsOnTheSafeSide) {
  // The proof in docs/algorithms/runtime/constrained_step.md uses that the true gap after a step is at least the row's
  // value less |r| angle^2 / 2.
  RowRig rig;
  Random random(4);
  for (int n = 0; n < 100; ++n) {
    const Configuration pose{test::randomPoint(random, 6), test::randomRotation(random)};
    const PairSet pairs = rig.pairsAt(pose);
    const RowSet set = makeRows(pairs, pose, RowForm::TrueDistance, Eigen::Matrix3d::Identity(), rig.memory());
    const Displacement step{test::randomPoint(random, 2), test::randomPoint(random, 0.2)};
    Vector6 y;
    y << step.translation, rig.scene.compiled().angle_length * step.rotation;
    const Configuration after = moved(pose, step);
    const double loss = rig.scene.compiled().tool.reach * step.rotation.squaredNorm() / 2;
    for (std::uint32_t k = 0; k < set.rows.count; ++k) {
      const auto [d, sum] = rig.distance(pairs, k, after);
      EXPECT_GE(d - sum, rowDot(set, k, y) - static_cast<double>(set.rows.b[k] / set.weight[k]) - loss - 1e-5);
    }
  }
}

TEST(Rows, CentresThatCoincideGetANormal) {
  SceneDescription d;
  d.tool = test::oneBallTree(1);
  d.objects.push_back({test::oneBallTree(2), {}});
  Scene scene;
  std::string fault;
  ASSERT_TRUE(compileScene(d, scene, fault));
  Workspace workspace(scene);
  const PairSet pairs = findPairs({}, 0, PairsOf::LeavesExactly, 1u << 30, workspace.memory());
  const RowSet set = makeRows(pairs, {}, RowForm::TrueDistance, Eigen::Matrix3d::Identity(), workspace.memory());
  ASSERT_EQ(set.rows.count, 1u);
  EXPECT_EQ(set.rows.a[2][0], 1);
  EXPECT_EQ(set.rows.b[0], 3);
  EXPECT_EQ(set.smallest_gap, -3);
}

TEST(Rows, KernelsGiveTheSameBits) {
  if (!isAvailable(Kernel::Avx2)) GTEST_SKIP() << "no AVX2 here";
  RowRig a(Kernel::Scalar), b(Kernel::Avx2);
  Random random(5);
  for (int n = 0; n < 20; ++n) {
    const Configuration pose{test::randomPoint(random, 6), test::randomRotation(random)};
    for (const RowForm form : {RowForm::TrueDistance, RowForm::SquaredDistance}) {
      const Eigen::Matrix3d axes = test::randomRotation(random).toRotationMatrix();
      const RowSet x = makeRows(a.pairsAt(pose), pose, form, axes, a.memory());
      const RowSet y = makeRows(b.pairsAt(pose), pose, form, axes, b.memory());
      ASSERT_EQ(x.rows.count, y.rows.count);
      for (std::size_t i = 0; i < 6; ++i) EXPECT_TRUE(std::equal(x.rows.a[i], x.rows.a[i] + x.rows.count, y.rows.a[i]));
      EXPECT_TRUE(std::equal(x.rows.b, x.rows.b + x.rows.count, y.rows.b));
      EXPECT_EQ(x.smallest_gap, y.smallest_gap);
    }
  }
}

}  // namespace
}  // namespace spheretree::runtime

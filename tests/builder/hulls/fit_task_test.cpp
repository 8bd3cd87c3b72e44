// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/fit_task.h"

#include <gtest/gtest.h>

#include <cmath>

#include "support/hull_fit.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

TEST(FitTask, SamplesLieOnTheSurfaceMoreOfThemForASmallerTolerance) {
  std::size_t before = 0;
  for (const double tolerance : {0.2, 0.1, 0.05}) {
    const test::HullFitRig rig(test::torusMesh(3, 1, 24, 12), tolerance);
    const std::vector<FitSample> samples = rig.task.samples();
    EXPECT_GT(samples.size(), 1.5 * static_cast<double>(before)) << tolerance;
    before = samples.size();
    for (const FitSample& s : samples) {
      EXPECT_LT(std::abs(rig.field.signedDistance(s.point)), 1e-9);
      EXPECT_NEAR(s.normal.norm(), 1, 1e-12);
      EXPECT_GT(rig.field.signedDistance(s.point + 1e-4 * s.normal), 0) << "outward";
    }
  }
}

TEST(FitTask, FindsBarePieces) {
  const test::HullFitRig rig(test::boxMesh({0, 0, 0}, {4, 4, 2}), 0.2);
  const auto bareWith = [&](std::vector<Hull> hulls) { return rig.task.bareOf(HullCover(hulls, rig.task.settings.margin())); };
  const FitTask::Bare all = bareWith({});
  EXPECT_EQ(all.pieces.size(), all.samples.size());
  EXPECT_TRUE(bareWith({Hull{.ball = {Ball{{2, 2, 1}, 4}}, .count = 1}}).pieces.empty()) << "a ball around everything";
  const FitTask::Bare some = bareWith({Hull{.ball = {Ball{{0, 0, 0}, 2.5}}, .count = 1}});
  EXPECT_GT(some.pieces.size(), 0u);
  EXPECT_LT(some.pieces.size(), all.pieces.size());
  for (const FitSample& s : some.samples) EXPECT_GT(s.point.norm(), 2.5 - 2 * rig.task.settings.margin());
}

}  // namespace
}  // namespace spheretree::builder

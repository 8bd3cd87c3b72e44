// SPDX-License-Identifier: GPL-3.0-or-later
#include "hulls/choose_hulls.h"

#include <gtest/gtest.h>

#include "hulls/hull_overhang.h"
#include "support/hull_fit.h"
#include "support/shapes.h"

namespace spheretree::builder {
namespace {

void expectCover(const test::HullFitRig& rig, const std::vector<Hull>& hulls) {
  Progress progress;
  EXPECT_TRUE(provenCovered(rig.mesh, hulls, Eigen::Vector3d::Zero(), progress));
  for (const Hull& hull : hulls)
    EXPECT_LE(hullOverhang(rig.field, hull, {.relative = 1e-3}).bound, rig.task.settings.tolerance * (1 + 2e-3));
}

TEST(ChooseHulls, CoversWithinTheToleranceWithoutRedundantHulls) {
  const test::HullFitRig rig(test::torusMesh(3, 1, 24, 12), 0.15);
  HullComplex complex = rig.joined();
  complex.compact();
  const ChosenHulls chosen = chooseHulls(complex);
  EXPECT_FALSE(chosen.is_thin);
  expectCover(rig, chosen.hulls);
  Progress progress;
  for (std::size_t i = 0; i < chosen.hulls.size(); ++i) {
    std::vector<Hull> others = chosen.hulls;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    EXPECT_FALSE(provenCovered(rig.mesh, others, Eigen::Vector3d::Zero(), progress)) << "hull " << i << " of " << chosen.hulls.size();
  }
}

// No ball is half of the tolerance deep in the plate: shallower ones hold the pieces, and the search for them ends.
TEST(ChooseHulls, BallsHoldWhatIsThinnerThanTheTolerance) {
  const test::HullFitRig rig(test::boxMesh({0, 0, 0}, {8, 6, 0.2}), 1);
  HullComplex complex(rig.task);
  complex.compact();
  const ChosenHulls chosen = chooseHulls(complex);
  EXPECT_TRUE(chosen.is_thin);
  expectCover(rig, chosen.hulls);
}

}  // namespace
}  // namespace spheretree::builder
